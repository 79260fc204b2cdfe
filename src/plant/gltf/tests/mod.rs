//! What importing and exporting promise, on files made here.

mod fixture;
mod foreign;
mod forms;
mod hostile;
mod own;
