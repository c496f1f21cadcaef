//! Surface properties read off a field: normals and albedo.
