//! Reports with a section for each device: a run replaces the section of the device that it ran on, and keeps the others, so that
//! devices of several machines stand in one file.
//!
//! In: the title, an introduction, the device, what was measured. Out: the whole page. It must not know what is measured.

use super::super::Error;
use oslcl_runtime::files::{self, Output};
use std::path::Path;

/// A page, but for its sections.
pub struct Page {
    /// The first line, without `# `.
    pub title: &'static str,
    /// What stands before the sections.
    pub intro: String,
}

/// A section: its name and its text, whose headings have three `#` at least.
type Section = (String, String);

impl Page {
    /// Writes a device's section into the file. A file that is no such page is replaced as a whole.
    pub fn write(&self, path: &Path, device: &str, body: &str) -> Result<(), Error> {
        let failed = |cause: std::io::Error| files::Error { path: path.to_owned(), cause: cause.into() };
        let old = match std::fs::read(path) {
            Ok(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
            Err(cause) if cause.kind() == std::io::ErrorKind::NotFound => String::new(),
            Err(cause) => return Err(failed(cause).into()),
        };
        let bytes = self.with(&old, device, body).into_bytes();
        Ok(files::replace(&[Output { path: path.to_owned(), bytes }])?)
    }

    /// The page with this section, and those of other devices that it has already.
    fn with(&self, old: &str, device: &str, body: &str) -> String {
        let mut sections = self.sections(old);
        let name = one_line(device);
        let body = format!("{}\n", body.trim());
        match sections.iter_mut().find(|(other, _)| *other == name) {
            Some((_, text)) => *text = body,
            None => sections.push((name, body)),
        }
        let mut out = format!("# {}\n\n{}\n", self.title, self.intro.trim());
        for (name, text) in sections {
            out.push_str(&format!("\n## {name}\n\n{text}"));
        }
        out
    }

    fn sections(&self, old: &str) -> Vec<Section> {
        let mut sections: Vec<Section> = Vec::new();
        if old.lines().next().is_none_or(|l| l.trim_end() != format!("# {}", self.title)) {
            return sections;
        }
        for line in old.lines() {
            match (line.strip_prefix("## "), sections.last_mut()) {
                (Some(name), _) => sections.push((name.trim().to_owned(), String::new())),
                (None, Some((_, text))) => {
                    text.push_str(line);
                    text.push('\n');
                }
                // What stands before the first section is written anew.
                (None, None) => {}
            }
        }
        for (_, text) in &mut sections {
            *text = format!("{}\n", text.trim());
        }
        sections
    }
}

/// A name that makes one heading.
fn one_line(name: &str) -> String {
    name.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page(intro: &str) -> Page {
        Page { title: "Times", intro: intro.to_owned() }
    }

    #[test]
    fn a_run_replaces_its_own_device_and_keeps_the_others() {
        let first = page("About.").with("", "CPU", "### scene\n\n| 1 |");
        assert_eq!(first, "# Times\n\nAbout.\n\n## CPU\n\n### scene\n\n| 1 |\n");
        let both = page("About it.").with(&first, "GPU  0", "| 2 |\n");
        assert_eq!(both, "# Times\n\nAbout it.\n\n## CPU\n\n### scene\n\n| 1 |\n\n## GPU 0\n\n| 2 |\n");
        let again = page("About it.").with(&both, "CPU", "| 3 |");
        assert_eq!(again, "# Times\n\nAbout it.\n\n## CPU\n\n| 3 |\n\n## GPU 0\n\n| 2 |\n");
        assert_eq!(page("About it.").with(&again, "CPU", "| 3 |"), again, "the same again changes nothing");
    }

    #[test]
    fn another_page_is_replaced() {
        let old = "# Something else\n\n## CPU\n\ntext\n";
        assert_eq!(page("About.").with(old, "GPU", "| 1 |"), "# Times\n\nAbout.\n\n## GPU\n\n| 1 |\n");
    }
}
