//! Studies from file to folder.
