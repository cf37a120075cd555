    printf("%d with a gap\n", seen[@MACRO@_GAP]);
