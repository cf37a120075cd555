    int below_count; /* with @MACRO@_GAP: intervals of c^2 below [lower, upper], the highest first */
    @NAME@_interval below[@MACRO@_BELOW];
