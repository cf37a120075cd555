/* @NOTICE@ */
/* Most intervals of a list, the highest first. */
enum { LIST = 1 + @MACRO@_BELOW };

static int has_intervals(@NAME@_status status) {
    return status == @MACRO@_OK || status == @MACRO@_UNBOUNDED || status == @MACRO@_GAP;
}

static @NAME@_status status_of(const @NAME@_interval *list, int count) {
    if (count != 1) return count > 1 ? @MACRO@_GAP : @MACRO@_EMPTY;
    return list[0].upper < MRTS_INFINITY ? @MACRO@_OK : @MACRO@_UNBOUNDED;
}

/* The intervals of a range, each with where it comes from; returns how many. */
static int intervals_of(const @NAME@_range *range, long from, @NAME@_interval *list) {
    list[0].lower = range->lower;
    list[0].upper = range->upper;
    list[0].lower_count = range->lower_count;
    list[0].upper_count = range->upper_count;
    for (int i = 0; i < K + 1; ++i) {
        list[0].lower_rows[i] = i < range->lower_count ? range->lower_rows[i] : 0;
        list[0].upper_rows[i] = i < range->upper_count ? range->upper_rows[i] : 0;
    }
    for (int i = 0; i < range->below_count; ++i) list[1 + i] = range->below[i];
    for (int i = 0; i < 1 + range->below_count; ++i) list[i].lower_from = list[i].upper_from = from;
    return 1 + range->below_count;
}

/* The same back into a range; none at all are the crossed ends of `intersect`. */
MRTS_LOCAL @NAME@_status tell(const @NAME@_interval *list, int count, @NAME@_range *range) {
    range->lower = list[0].lower;
    range->upper = list[0].upper;
    range->lower_count = list[0].lower_count;
    range->upper_count = list[0].upper_count;
    for (int i = 0; i < list[0].lower_count; ++i) range->lower_rows[i] = list[0].lower_rows[i];
    for (int i = 0; i < list[0].upper_count; ++i) range->upper_rows[i] = list[0].upper_rows[i];
    range->below_count = count > 0 ? count - 1 : 0;
    for (int i = 0; i < range->below_count; ++i) range->below[i] = list[1 + i];
    return range->status = status_of(list, count);
}

/* What two intervals have in common: the ends of the first where they are those of both. */
static @NAME@_interval overlap(const @NAME@_interval *one, const @NAME@_interval *other) {
    @NAME@_interval both = *one;
    if (other->lower > one->lower || one->lower_from < 0) {
        both.lower = other->lower;
        both.lower_from = other->lower_from;
        both.lower_count = other->lower_count;
        for (int i = 0; i < K + 1; ++i) both.lower_rows[i] = other->lower_rows[i];
    }
    if (other->upper < one->upper) {
        both.upper = other->upper;
        both.upper_from = other->upper_from;
        both.upper_count = other->upper_count;
        for (int i = 0; i < K + 1; ++i) both.upper_rows[i] = other->upper_rows[i];
    }
    return both;
}

/* What two lists have in common, in place of the first; returns how many, and where nothing is common leaves the crossed
 * ends of the highest intervals. */
static int intersect(@NAME@_interval *list, int count, const @NAME@_interval *others, int other_count) {
    @NAME@_interval common[LIST];
    int found = 0, i = 0, j = 0;
    while (i < count && j < other_count && found < LIST) {
        const @NAME@_interval both = overlap(list + i, others + j);
        if (both.lower <= both.upper) common[found++] = both;
        if (list[i].lower > others[j].lower) {
            ++i;
        } else {
            ++j;
        }
    }
    if (found == 0) list[0] = overlap(list, others);
    for (int n = 0; n < found; ++n) list[n] = common[n];
    return found;
}
