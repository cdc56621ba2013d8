//! The choices between accuracy and time, from the command line.

use super::Error;
use super::args::ChoiceArgs;
use oslcl_runtime::choices::Choices;
use oslcl_runtime::plan::Overrides;

/// The profile, then `--set` in order, then `--precision`.
pub fn of(args: &ChoiceArgs) -> Result<Choices, Error> {
    let usage = |option: &str, why: String| Error::Usage(format!("`{option}`: {why}"));
    let mut choices =
        Choices::profile(&args.profile).map_err(|e| usage(&format!("--profile {}", args.profile), e.to_string()))?;
    for text in &args.set {
        let option = format!("--set {text}");
        let Some((name, value)) = text.split_once('=') else {
            return Err(usage(&option, "expected NAME=VALUE, such as --set sampler=independent".to_owned()));
        };
        choices.set(name.trim(), value.trim()).map_err(|e| usage(&option, e.to_string()))?;
    }
    if let Some(precision) = args.precision {
        choices.precision = precision.into();
    }
    choices.overrides = Overrides::by_name(&args.force, &args.without).map_err(|e| Error::Usage(e.to_string()))?;
    Ok(choices)
}
