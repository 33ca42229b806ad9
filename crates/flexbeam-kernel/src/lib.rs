#![no_std]
//! All that runs inside the loop.
