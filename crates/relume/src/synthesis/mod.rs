//! Synthesis: from index planes to a map of where each output texel comes from.
