/* @NOTICE@
 * A plan of the cell, s from 0 to its duration. */
#include "cell_override.h"

static const char *const LIMITS[] = @LIMIT_TEXT@;
static const cell_plan_node NODES[@NODES@] = @NODE_ROWS@;
const cell_plan cell_planned = {
    NODES, @NODES@, @PLAN_BACKWARDS@, @PLAN_VARIES@, @PLAN_KEEPS_RATES@, LIMITS,
    @PLAN_LOAD@,
#if CELL_MOTORS
    @PLAN_ARMATURE@,
    @PLAN_COULOMB@,
    @PLAN_VISCOUS@,
#endif
};
