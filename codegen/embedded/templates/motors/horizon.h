    int below_count; /* with @MACRO@_GAP: intervals below [lower, upper], the highest first */
    @NAME@_interval below[@MACRO@_BELOW];
