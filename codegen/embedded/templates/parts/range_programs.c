/* @NOTICE@ */
#ifdef MRTS_SINGLE
#define BINDING MRTS_C(1e-4) /* a row binds if its multiplier exceeds this share of the largest */
#else
#define BINDING 1e-7
#endif

typedef char lp_work_holds[HOLDS(work, mrts_real, MRTS_LP_WORK(K))];
typedef char lp_integers_hold[HOLDS(integers, int, MRTS_LP_IWORK(K, ROWS))];

/* A row of the programs as @NAME@_range names it; `velocity` bounds c^2 by itself. */
static int name_of(int code, int at_lower, const mrts_rows *rows, int velocity) {
    const int row = (code < 0 ? -code : code) - 1;
    if (row >= rows->count) return at_lower ? 0 : velocity;
    return at_lower ? -rows->which[row] - 1 : rows->which[row] + 1;
}

/* Rows with a multiplier, the strongest first; returns how many. The side is that of the basis, or of a certificate's
 * multiplier. */
static int name_rows(const int *basis, const mrts_real *y, const mrts_rows *rows, int velocity, int by_sign,
                     int *named) {
    mrts_real largest = 0, strength[K];
    int count = 0;
    for (int j = 0; j < K; ++j) largest = mrts_larger(largest, MRTS_ABS(y[j]));
    for (int j = 0; j < K; ++j) {
        const mrts_real its = MRTS_ABS(y[j]);
        if (its <= BINDING * largest) continue;
        int at = count++;
        for (; at > 0 && its > strength[at - 1]; --at) {
            strength[at] = strength[at - 1];
            named[at] = named[at - 1];
        }
        strength[at] = its;
        named[at] = name_of(basis[j], by_sign ? y[j] > 0 : basis[j] < 0, rows, velocity);
    }
    return count;
}

/* A kept basis that does not fit these rows starts cold. */
static void check_basis(int k, int *basis, int rows) {
    if (basis[0] == 0) return;
    for (int j = 0; j < k; ++j) {
        if (basis[j] == 0 || mrts_abs(basis[j]) > rows + k) {
            basis[0] = 0;
            return;
        }
    }
}

static @NAME@_status solve_end(const mrts_rows *rows, int velocity, mrts_real sign, int *basis, mrts_real column,
                               @NAME@_workspace *workspace, mrts_real *end, int *count, int *named) {
    mrts_real g[K], x[K], y[K];
    int entering = 0;
    for (int j = 0; j < K; ++j) g[j] = j == F ? sign : 0;
    check_basis(K, basis, rows->count);
    const int status = mrts_lp_again(K, rows->count, rows->A, rows->lower, rows->upper, g, basis, x, y, &entering,
                                     workspace->work, workspace->integers);
    if (status == MRTS_INFEASIBLE) {
        named[0] = name_of(entering, entering < 0, rows, velocity);
        *count = name_rows(basis, y, rows, velocity, 1, named + 1) + 1;
        basis[0] = 0;
        return @MACRO@_INFEASIBLE;
    }
    if (status != MRTS_OPTIMAL) {
        basis[0] = 0;
        *count = 0;
        return @MACRO@_UNDECIDED;
    }
    *end = x[F] * column;
    if (*end < 0) *end = 0;
    if (sign < 0 && !velocity && x[F] >= MRTS_UNBOUNDED * (1 - 10 * MRTS_FEASIBLE)) return @MACRO@_UNBOUNDED;
    *count = name_rows(basis, y, rows, velocity, 0, named);
    return @MACRO@_OK;
}
