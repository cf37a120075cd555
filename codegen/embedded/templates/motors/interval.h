/* One interval of c^2: its ends and the rows that bind there, as in @NAME@_range; `from` are the samples of a horizon or
 * the loads that set the ends, -1 where none does. */
typedef struct {
    @NAME@_real lower, upper;
    long lower_from, upper_from;
    int lower_count, upper_count;
    int lower_rows[@MACRO@_UNKNOWNS + 1];
    int upper_rows[@MACRO@_UNKNOWNS + 1];
} @NAME@_interval;
