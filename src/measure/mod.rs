//! What `bench` measures with: clocks, whose turn it is, and what times say.

pub(crate) mod machine;
pub(crate) mod rounds;
pub(crate) mod statistics;
