//! The cases of the paper, run from their files, against exact solutions.

mod poroelastic_column;
