"""What a user writes: TOML, checked, each mistake located."""
