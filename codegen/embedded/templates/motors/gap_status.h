    @MACRO@_GAP = 6,         /* as @MACRO@_OK, but with intervals of c^2 below it; between them none is admissible */
