    @NAME@_place place;                 /* @MACRO@_INSIDE, which is 0, but for the first and the last sample */
