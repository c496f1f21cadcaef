//! Captures: light files, folders of photographs, and the virtual light dome.
