# `just` runs what must pass before a change lands; `.ci/run` is the same for machines without just.
default: fmt-check lint test doc

# All tests of the workspace.
test:
    cargo test --workspace

# Rewrites golden images, diagnostics, derived tables and the README's console blocks.
bless:
    GMLVM_BLESS=1 cargo test --workspace

fmt:
    cargo fmt --all

fmt-check:
    cargo fmt --all --check

lint:
    cargo clippy --workspace --all-targets -- -D warnings

doc:
    RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --document-private-items

# Licences, duplicates and sources of the dependencies (needs cargo-deny).
deny:
    cargo deny check licenses bans sources

# The book of docs/, as pages in target/book (needs mdbook).
book:
    mdbook build docs

# Renders the pictures of docs/gallery from scenes/, that of the README larger than it asks for.
gallery:
    cargo build --release
    for scene in scenes/*.gml; do \
        cargo run --release --quiet -- run "$scene" --format png -o docs/gallery || exit 1; \
    done
    cargo run --release --quiet -- run scenes/showpiece.gml --size 960x640 --format png -o docs/gallery

# Measures all charts of docs/accuracy.md again, which takes some minutes; nothing else should run.
charts:
    cargo build --release
    cargo run --release --quiet -- chart --size 160x120 \
        scenes/hello.gml scenes/die.gml scenes/marble.gml scenes/csg-gears.gml \
        scenes/mirror-room.gml scenes/texture-faces.gml scenes/flake.gml tests/stability/thin-shell.gml \
        --export docs/charts/rounding.json -o docs/charts/rounding.svg
    cargo run --release --quiet -- chart --size 80x60 --methods sampling --runs 3 \
        scenes/hello.gml scenes/die.gml scenes/csg-gears.gml scenes/mirror-room.gml \
        --export docs/charts/sampling.json -o docs/charts/sampling.svg
    just chart-set distance
    just chart-set stability
    just chart-set bounces
    just chart-set certainty --size 160x120 --runs 5 scenes/*.gml
    just chart-set bounds --size 96x72 \
        scenes/hello.gml scenes/die.gml scenes/marble.gml scenes/csg-gears.gml \
        scenes/mirror-room.gml scenes/texture-faces.gml scenes/kaleidoscope.gml scenes/lamp.gml
    just chart-set omissions --size 160x120 \
        scenes/hello.gml scenes/die.gml scenes/csg-gears.gml scenes/mirror-room.gml \
        scenes/dominoes.gml scenes/chicago-attenuation.gml
    just chart-set differences --size 60x45 \
        scenes/csg-gears.gml scenes/mirror-room.gml scenes/kaleidoscope.gml \
        tests/stability/thin-shell.gml tests/stability/flush-drill.gml
    just chart-set threads --size 320x240 \
        scenes/hello.gml scenes/die.gml scenes/csg-gears.gml scenes/mirror-room.gml scenes/flake.gml

# Measures a set of charts again; further arguments are those of `gmlvm chart`.
[private]
chart-set set *args:
    cargo run --release --quiet -- chart --set {{set}} {{args}} \
        --export docs/charts/{{set}}.json -o docs/charts/{{set}}.svg

# Measures the chart of docs/scaling.md again, which takes some minutes; nothing else should run.
scaling:
    cargo build --release
    cargo run --release --quiet -- chart --scaling --runs 9 \
        --export docs/charts/scaling.json -o docs/charts/scaling.svg

# A Debian package, with manual pages, completions, the book and scenes (needs cargo-deb).
deb *args:
    contrib/debian-package.sh {{args}}

# Fuzzes all targets, SECONDS each, and minimises their corpora (needs cargo-fuzz and nightly).
nightly seconds="300":
    fuzz/nightly.sh {{seconds}}

# Fuzzes a target of fuzz/ (needs cargo-fuzz and nightly); further arguments are libFuzzer's.
fuzz target *args:
    cargo +nightly fuzz run {{target}} -- {{args}}

# Surface functions interpreted, as machine code, in Rust and in Lua, ns a call.
bench:
    cargo bench --bench surfaces

# Times kernels, scenes and benchmark scenes, and writes tables into the directory `out`.
history out:
    cargo build --release
    python3 benches/history.py "{{out}}"

# Times rays beside those of Embree 3, into the directory `out` (needs g++ and libembree-dev).
rays out:
    cargo build --release
    python3 benches/rays.py "{{out}}"

# Times scenes beside POV-Ray and pictures written by hand, into the directory `out`.
peers out:
    cargo build --release
    python3 benches/peers.py "{{out}}"
