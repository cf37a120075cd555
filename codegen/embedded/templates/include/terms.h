/* Terms of (11) to (18): torque = E r'^2 + A r'' + G + J'F of each arm, sum B F = P r'^2 + S r'' + Q of the object. J
 * and B stand arm beside arm, column after column: J has @MACRO@_WRENCH rows and @MACRO@_JOINTS columns, B
 * @MACRO@_WRENCH rows and @MACRO@_WRENCHES columns. */
typedef struct {
    @NAME@_real E[@MACRO@_JOINTS], A[@MACRO@_JOINTS], G[@MACRO@_JOINTS];
    @NAME@_real J[@MACRO@_WRENCH * @MACRO@_JOINTS], B[@MACRO@_WRENCH * @MACRO@_WRENCHES];
    @NAME@_real P[@MACRO@_WRENCH], S[@MACRO@_WRENCH], Q[@MACRO@_WRENCH];@MOTOR_TERMS_FIELDS@
} @NAME@_terms_of_sample;

void @NAME@_terms(const @NAME@_sample *sample, const @NAME@_settings *settings, @NAME@_terms_of_sample *terms);
