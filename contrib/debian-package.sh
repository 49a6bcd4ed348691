#!/usr/bin/env bash
# Makes a Debian package of gmlvm by cargo-deb, in target/debian; arguments are for `cargo deb`. What the package holds
# besides the program and the sources' own files is made in target/deb.
set -euo pipefail
cd "$(dirname "$0")/.."

cargo build --release --package gmlvm
gmlvm=${CARGO_TARGET_DIR:-target}/release/gmlvm

made=target/deb
rm -rf "$made"
mkdir -p "$made/completions"
"$gmlvm" man "$made/man"
"$gmlvm" completions bash >"$made/completions/gmlvm"
"$gmlvm" completions zsh >"$made/completions/_gmlvm"
"$gmlvm" completions fish >"$made/completions/gmlvm.fish"

# Both licences: the package is under either.
{
    cat <<'HEAD'
Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: gmlvm

Files: *
Copyright: 2026 The gmlvm developers
License: MIT or Apache-2.0

License: MIT
HEAD
    # The text of a licence, indented, with points for empty lines.
    sed -n '5,$p' LICENSE-MIT | sed 's/^$/./; s/^/ /'
    cat <<'TAIL'

License: Apache-2.0
 On Debian systems the text is in /usr/share/common-licenses/Apache-2.0.
TAIL
} >"$made/copyright"

cargo deb --no-build --strip "$@"
