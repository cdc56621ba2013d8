#!/bin/sh
# Builds and runs a fuzz target, or packs all of them for another machine. See README.md.
set -eu
cd "$(dirname "$0")"
TARGETS="preprocessor parser checker whole_road"
LIMITS="-dict=osl.dict -rss_limit_mb=1024 -timeout=10 -max_len=4096"

build() {
    RUSTC_BOOTSTRAP=1 cargo fuzz build --sanitizer none "$@"
}

binary() {
    ls target/*/release/"$1" | head -n 1
}

# The seeds of a folder, flat.
seeds() {
    mkdir -p "$1"
    for file in ../tests/corpus/*.osl ../tests/corpus/run/*.osl ../tests/corpus/errors/*.osl ../tests/corpus/language/*.osl ../shaders-osl/*.osl; do
        cp "$file" "$1/$(basename "$(dirname "$file")")-$(basename "$file")"
    done
}

case "${1:-}" in
    "" | -h | --help)
        echo "usage: fuzz.sh TARGET SECONDS | fuzz.sh pack DIR     targets: $TARGETS"
        ;;
    pack)
        build
        mkdir -p "$2"
        for target in $TARGETS; do
            cp "$(binary "$target")" "$2/"
        done
        cp osl.dict "$2/"
        seeds "$2/seeds"
        cat > "$2/run.sh" <<RUN
#!/bin/sh
# Runs each target for as many seconds as the first argument says; fails when one finds something.
set -eu
cd "\$(dirname "\$0")"
status=0
for target in ${TARGETS}; do
    mkdir -p corpus/\$target artifacts
    ./\$target corpus/\$target seeds ${LIMITS} -artifact_prefix=artifacts/\$target- -max_total_time="\${1:-600}" \\
        > \$target.log 2>&1 || status=1
    echo "\$target: \$(tail -n 1 \$target.log)"
done
exit \$status
RUN
        chmod +x "$2/run.sh"
        ;;
    *)
        build "$1"
        mkdir -p "corpus/$1" "artifacts/$1"
        seeds corpus/seeds
        exec "$(binary "$1")" "corpus/$1" corpus/seeds $LIMITS -artifact_prefix="artifacts/$1/" -max_total_time="${2:-600}"
        ;;
esac
