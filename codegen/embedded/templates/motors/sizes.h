    LINES = @MACRO@_LINES,
    ENDS = @ENDS@,
