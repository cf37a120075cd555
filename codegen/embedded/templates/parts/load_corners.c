/* @NOTICE@ */
const @NAME@_real @NAME@_load_corners[@MACRO@_CORNERS][@MACRO@_LOAD] = {
@LOAD_CORNERS@
};
