"""One look per file: places features on a surface once, then answers for any sample."""
