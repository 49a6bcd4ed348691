# `just` runs what must pass before a change lands.
default: fmt-check lint test doc

# All tests of the workspace.
test:
    cargo test --workspace

# Rewrites golden files after an intended change.
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

# Renders the pictures of docs/gallery from scenes/.
gallery:
    cargo build --release
    for scene in scenes/*.gml; do \
        target/release/gmlvm run "$scene" --format png --output "docs/gallery/{name}.png"; \
    done

# The interpreter on three surface functions, ns a call.
bench:
    cargo bench --bench surfaces
