# The command in a container: docker build -t cotree . && docker run --rm -v "$PWD:/work" cotree check scene.toml
#
# `cotree view` and `cotree draw` write pages into the folder, with the solver inside: a page that the container served would reach no browser outside of it.
FROM rust:1.95-slim-bookworm AS build
RUN rustup target add wasm32-unknown-unknown && apt-get update && apt-get install -y --no-install-recommends python3 && rm -rf /var/lib/apt/lists/*
WORKDIR /cotree
COPY . .
RUN tools/build-runtimes.sh web && CARGO_PROFILE_RELEASE_LTO=false cargo build --release --locked --bin cotree \
    && cargo metadata --locked --format-version 1 --filter-platform "$(rustc -vV | sed -n 's/^host: //p')" | python3 tools/licences.py target/licences

FROM debian:bookworm-slim
COPY --from=build /cotree/target/release/cotree /usr/local/bin/cotree
COPY --from=build /cotree/target/runtimes /usr/local/bin/runtimes
COPY --from=build /cotree/target/licences /cotree/LICENSE-MIT /cotree/LICENSE-APACHE /usr/local/share/doc/cotree/
COPY --from=build /cotree/models /usr/local/share/cotree/models
WORKDIR /work
ENTRYPOINT ["cotree"]
