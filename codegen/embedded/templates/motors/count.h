#define @MACRO@_LINES @LINES@       /* lines of torque-speed curves: rows that fall with the speed */
#define @MACRO@_BELOW 3       /* most intervals of c^2 that are told below the one with the largest c^2 */
