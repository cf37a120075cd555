    int curve_basis[3 * (@MACRO@_UNKNOWNS + 1)], curve_integers[@MACRO@_ROWS + 7 + 6 * @MACRO@_UNKNOWNS];
