//! Files: everything about encodings, quantisation and row orders.
