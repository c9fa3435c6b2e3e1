//! Local descent on a [`Space`](crate::space::Space).
