//! The C ABI of Relievo.
