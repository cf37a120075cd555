    @NAME@_real V[@MACRO@_JOINTS], C[@MACRO@_JOINTS]; /* friction: torque = ... + V r' + C, of motors; E, A have armature */
    @NAME@_real turning[@MACRO@_JOINTS]; /* dry friction of a joint that turns back: it acts in both directions; C is 0 */
