"""Rows of large tables, taken and put by number: in one pass what numpy does in several."""

from surftex.kernels.jit import kernel


@kernel
def take_samples(row, face, barycentric, footprint, face_taken, barycentric_taken, footprint_taken):
    """Take samples: row (k,) int32; face (n,) int32, barycentric (n, 3), footprint (n,) float32 -> the same, taken."""
    for i in range(len(row)):
        r = row[i]
        face_taken[i] = face[r]
        barycentric_taken[i, 0] = barycentric[r, 0]
        barycentric_taken[i, 1] = barycentric[r, 1]
        barycentric_taken[i, 2] = barycentric[r, 2]
        footprint_taken[i] = footprint[r]


@kernel
def put_rows(row, low, high, value, table):
    """Write value (k, c) into the rows row (k,) int64 of table (n, c), those from `low` to before `high` alone."""
    for i in range(len(row)):
        r = row[i]
        if low <= r < high:
            for c in range(table.shape[1]):
                table[r, c] = value[i, c]


@kernel
def repeat_rows(row, source, table):
    """Write into the rows row (k,) int64 of table (n, c) what its rows source (k,) int64 hold."""
    for i in range(len(row)):
        r = row[i]
        s = source[i]
        for c in range(table.shape[1]):
            table[r, c] = table[s, c]


@kernel
def sum_rows(row, table, total):
    """Add the rows row (k,) int64 of table (n, c) to total (c,) float64, one after another."""
    for c in range(table.shape[1]):
        value = 0.0
        for i in range(len(row)):
            value += table[row[i], c]
        total[c] += value
