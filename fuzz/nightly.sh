#!/usr/bin/env bash
# Fuzzes each target for so many seconds, says what came of it, and keeps of each corpus the inputs that
# are needed to reach what it reaches:
#
#     fuzz/nightly.sh [SECONDS [TARGET...]]
#
# Needs cargo-fuzz and a nightly toolchain. Inputs begin with the scenes and small programs of the
# repository, and with parts that gmlvm makes of a scene. GMLVM_FUZZ_SANITIZER is `none` for three times as many executions, or `address`. Ends
# with 1 if a target has found something; its file in fuzz/artifacts is input for
# `cargo +nightly fuzz run TARGET FILE`. When the bug is mended, the file goes to fuzz/finds/TARGET, where
# tests/fuzzed.rs, tests/differential.rs (engines) or src/fuzzed.rs (parts, paths) tries it again for ever.
set -euo pipefail
cd "$(dirname "$0")/.."

seconds=${1:-300}
shift || true
targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=(lexer parser compiler engines parts paths)
fuzz=(cargo +nightly fuzz)
sanitizer=(--sanitizer "${GMLVM_FUZZ_SANITIZER:-address}")

# Words of the language, for the targets that read text.
dictionary=$(mktemp)
seeds=$(mktemp -d)
mkdir "$seeds/tmp"
export TMPDIR=$seeds/tmp
trap 'rm -rf "$dictionary" "$seeds"' EXIT
sed -n 's/^| `\([a-z]\+\)`.*/"\1"/p' docs/language.md | sort -u >"$dictionary"
printf '%s\n' '"{"' '"}"' '"["' '"]"' '"/x"' '"\x0a#if "' '"\x0a#endif\x0a"' '"1e999"' >>"$dictionary"

# Parts of a small image, each behind the byte that says "any file".
cargo run --release --quiet -- run scenes/hello.gml --size 6x5 --parts "$seeds/made" -o "$seeds" -q
mkdir "$seeds/parts"
for part in "$seeds"/made/*.part; do
    { printf '\0'; cat "$part"; } >"$seeds/parts/$(basename "$part")"
done

failed=0
for target in "${targets[@]}"; do
    corpus=fuzz/corpus/$target
    mkdir -p "$corpus"
    options=(-max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 -verbosity=0)
    more=()
    case $target in
        lexer | parser | compiler)
            options+=(-dict="$dictionary" -max_len=4096)
            more=(scenes tests/lang)
            ;;
        parts) more=("$seeds/parts") ;;
    esac
    log=fuzz/corpus/$target.log
    if "${fuzz[@]}" run "${sanitizer[@]}" "$target" "$corpus" "${more[@]}" -- "${options[@]}" >"$log" 2>&1; then
        result='nothing found'
    else
        result="FOUND SOMETHING: see $log"
        failed=1
    fi
    runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
    printf '%-9s %12s runs  %s\n' "$target" "${runs:-?}" "$result"
    "${fuzz[@]}" cmin "${sanitizer[@]}" "$target" "$corpus" >>"$log" 2>&1
done
exit $failed
