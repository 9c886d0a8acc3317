"""The room that owns UV: unwrap, gate, texels, gutter, seam measure."""
