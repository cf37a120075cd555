
/* Where in its motion a sample lies. That tells what dry friction does in a joint that stands there (q' = 0): it is
 * against the direction in which the joint travels just before and just after. */
typedef enum {
    @MACRO@_INSIDE = 0, /* both: where the joint turns back, limits hold with the friction of either direction */
    @MACRO@_START = 1,  /* the motion begins here: only after, along q'' */
    @MACRO@_END = 2     /* it ends here: only before, against q'' */
} @NAME@_place;
