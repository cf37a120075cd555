#define @MACRO@_REST_SPEED @REST_SPEED@ /* of their motion: what is rounding of rest */
#define @MACRO@_REST_ACCELERATION @REST_ACCELERATION@
