/* SPDX-License-Identifier: MIT
 *
 * The cell of an exported library. What begins with cell_ and CELL_ takes the library's name there. The model, constants
 * and tables are generated. */
#include "cell.h"
#include "cell_model.h"

/* All but the model as one text, which is faster: the sizes of the cell are constants in the kernel too. */
#include "../rows.h"
#if CELL_POINTS || CELL_THINGS
#include "../point_motion.h"
#endif
#include "../linear_programs.h"
#if CELL_MOTORS
#include "../speed_intervals.h"
#endif
#include "../quadratic_programs.h"
#include "cell_tables.h"

#if CELL_ENDS
#define END_JOINT(end) ((end) < 0 ? -1 : end_joint[end])
#else
#define END_JOINT(end) -1
#endif

enum { JOINTS = CELL_JOINTS, WRENCHES = CELL_WRENCHES, ROWS = CELL_ROWS, VELOCITIES = CELL_VELOCITIES };
enum { K = CELL_UNKNOWNS, F = CELL_UNKNOWNS - 1 };

/* An error at compile time where the workspace does not hold what the kernel asks for. */
#define HOLDS(field, type, count) (sizeof(((cell_workspace *)0)->field) >= (count) * sizeof(type))
typedef char workspace_holds[HOLDS(rows, mrts_real, MRTS_ROWS_WORK(K, ROWS)) && HOLDS(which, int, MRTS_ROWS_IWORK(ROWS)) &&
                             HOLDS(form, mrts_real, MRTS_FORM_WORK(K, JOINTS, WRENCHES)) &&
                             HOLDS(work, mrts_real, MRTS_LP_WORK(K)) && HOLDS(integers, int, MRTS_LP_IWORK(K, ROWS)) &&
                             HOLDS(work, mrts_real, MRTS_QP_WORK(F)) && HOLDS(integers, int, MRTS_QP_IWORK(F, ROWS))
                                 ? 1 : -1];
#if CELL_TURNED
typedef char turned_holds[HOLDS(turned, mrts_real, MRTS_TURNED_WORK(K, WRENCHES)) ? 1 : -1];
#endif
#if CELL_MOTORS
typedef char curve_holds[HOLDS(curve, mrts_real, MRTS_CURVE_WORK(K, ROWS)) &&
                         HOLDS(curve_integers, int, MRTS_CURVE_IWORK(K, ROWS)) &&
                         HOLDS(basis, int, 2 * K + MRTS_CURVE_BASES * (K + 1)) ? 1 : -1];
#endif

/* Whether all values are finite, and their sum too. */
static int all_finite(int count, const mrts_real *values) {
    mrts_real sum = 0;
    for (; count > 0; --count) sum += MRTS_ABS(*values++);
    return sum < MRTS_INFINITY;
}

const char *cell_status_text(cell_status status) {
    static const char *const texts[] = {"ok", "unbounded: nothing limits the speed",
                                        "infeasible: limits conflict at every speed", "empty: no c^2 in common",
                                        "undecided at this precision", "bad argument"};
    return (unsigned)status <= CELL_BAD_ARGUMENT ? texts[status] : "unknown status";
}

const char *cell_row_text(int row) {
    const int place = row < 0 ? -row : row;
    return place < (int)(sizeof ROW_TEXT / sizeof *ROW_TEXT) ? ROW_TEXT[place] : "unknown row";
}

void cell_default_settings(cell_settings *settings) { *settings = DEFAULTS; }

static int are_positive(int count, const mrts_real *values) {
    int sound = 1;
    for (int i = 0; i < count; ++i) sound &= values[i] > 0;
    return sound;
}

static int has_sound_motions(const cell_settings *settings) {
    int sound = are_positive(VELOCITIES, settings->velocity);
#if CELL_MOTIONS
    sound &= are_positive(JOINTS, settings->acceleration_upper) && are_positive(2, settings->object_acceleration);
    for (int i = 0; i < JOINTS; ++i) sound &= settings->acceleration_lower[i] < 0;
#endif
#if CELL_POINTS
    sound &= are_positive(CELL_POINTS, settings->point_speed);
    sound &= are_positive(CELL_POINTS, settings->point_acceleration);
#endif
#if CELL_THINGS
    sound &= are_positive(CELL_THINGS, settings->friction) && are_positive(2 * CELL_THINGS, settings->tilt);
#endif
    return sound;
}

cell_status cell_check_settings(const cell_settings *settings) {
    int sound = settings->load[0] > 0 && all_finite(CELL_LOAD, settings->load) && all_finite(JOINTS, settings->weight);
    for (int i = 0; i < ROWS; ++i) sound &= settings->lower[i] <= settings->upper[i];
    sound &= are_positive(JOINTS, settings->weight) && has_sound_motions(settings);
#if CELL_MOTORS
    sound &= all_finite(JOINTS, settings->armature) && all_finite(JOINTS, settings->coulomb);
    sound &= all_finite(JOINTS, settings->viscous) && settings->rest_speed >= 0 && settings->rest_acceleration >= 0;
    for (int i = 0; i < JOINTS; ++i) {
        sound &= settings->armature[i] >= 0 && settings->coulomb[i] >= 0 && settings->viscous[i] >= 0;
    }
    sound &= settings->most > 0;
#endif
#if CELL_LINES
    for (int i = 0; i < CELL_LINES; ++i) sound &= settings->slope[i] >= 0 && settings->slope[i] < MRTS_INFINITY;
#endif
    return sound ? CELL_OK : CELL_BAD_ARGUMENT;
}

void cell_reset(cell_workspace *workspace) {
    for (unsigned j = 0; j < sizeof workspace->basis / sizeof *workspace->basis; ++j) workspace->basis[j] = 0;
#if CELL_MOTORS
    workspace->curve_speed = 0;
#endif
}

void cell_horizon_start(cell_horizon *horizon) {
    horizon->status = CELL_UNBOUNDED;
    horizon->lower = 0;
    horizon->upper = MRTS_INFINITY;
    horizon->samples = 0;
    horizon->lower_sample = horizon->upper_sample = -1;
}

cell_status cell_horizon_add(cell_horizon *horizon, const cell_range *range) {
    const long sample = horizon->samples++;
    const int joined = horizon->status == CELL_OK || horizon->status == CELL_UNBOUNDED;
    if (!joined) return horizon->status;
    if (range->status != CELL_OK && range->status != CELL_UNBOUNDED) {
        horizon->lower_sample = horizon->upper_sample = sample;
        return horizon->status = range->status;
    }
    if (range->lower > horizon->lower || horizon->lower_sample < 0) {
        horizon->lower = range->lower;
        horizon->lower_sample = sample;
    }
    if (range->upper < horizon->upper) {
        horizon->upper = range->upper;
        horizon->upper_sample = sample;
        horizon->status = CELL_OK;
    }
    if (horizon->lower > horizon->upper) horizon->status = CELL_EMPTY;
    return horizon->status;
}

/* Inputs of the generated functions; matrices there are column after column, hence the rotation `turned`. */
static void point_to(const cell_sample *sample, const mrts_real *load, mrts_real turned[9], const mrts_real **arg) {
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) turned[3 * j + i] = sample->rotation[3 * i + j];
    }
    arg[0] = sample->q;
    arg[1] = sample->dq;
    arg[2] = sample->ddq;
    arg[3] = turned;
    arg[4] = sample->twist;
    arg[5] = sample->acceleration;
    arg[6] = load;
}

#if CELL_MOTORS
static int sign_beyond(mrts_real value, mrts_real rest) { return value > rest ? 1 : value < -rest ? -1 : 0; }

/* Dry friction of a joint, against its velocity just before and just after a sample: where q' = 0 it arrives against q'' and
 * leaves along it. Where it turns back that is 0, and acts in both directions with `turning`. */
static mrts_real dry_friction(const cell_sample *sample, const cell_settings *settings, int joint, mrts_real *turning) {
    const int moving = sign_beyond(sample->dq[joint], settings->rest_speed);
    const int leaving = sign_beyond(sample->ddq[joint], settings->rest_acceleration);
    int before = moving != 0 ? moving : -leaving, after = moving != 0 ? moving : leaving;
    if (sample->place == CELL_START) before = after;
    if (sample->place == CELL_END) after = before;
    *turning = before != after ? settings->coulomb[joint] : 0;
    return before == after ? settings->coulomb[joint] * (mrts_real)after : 0;
}
#endif

void cell_terms(const cell_sample *sample, const cell_settings *settings, cell_terms_of_sample *terms) {
    mrts_real turned[9];
    const mrts_real *arg[7];
    mrts_real *const res[] = {terms->E, terms->A, terms->G, terms->J, terms->B, terms->P, terms->S, terms->Q};
    point_to(sample, settings->load, turned, arg);
    cell_model_terms(arg, res);
#if CELL_MOTORS
    for (int joint = 0; joint < JOINTS; ++joint) {
        terms->E[joint] += settings->armature[joint] * sample->ddq[joint];
        terms->A[joint] += settings->armature[joint] * sample->dq[joint];
        terms->V[joint] = settings->viscous[joint] * sample->dq[joint];
        terms->C[joint] = dry_friction(sample, settings, joint, &terms->turning[joint]);
    }
#endif
}

#define NO_EFFECT MRTS_C(1e-30) /* an effect of c^2 = 1 on a limit below this share of it is none */
#define UNLIKELY MRTS_C(1e24) /* c^2 that only rounding of rest allows: velocities are below 1e-12 of their limits */

/* Whether all numbers of a sample and its load are finite, and the mass is > 0. */
static int is_sound(const cell_sample *sample, const mrts_real *load) {
    mrts_real sum = 0;
    for (int i = 0; i < JOINTS; ++i) sum += MRTS_ABS(sample->q[i]) + MRTS_ABS(sample->dq[i]) + MRTS_ABS(sample->ddq[i]);
    for (int i = 0; i < 6; ++i) sum += MRTS_ABS(sample->twist[i]) + MRTS_ABS(sample->acceleration[i]);
    return sum < MRTS_INFINITY && all_finite(9, sample->rotation) && all_finite(CELL_LOAD, load) && load[0] > 0;
}

static mrts_limits limits_of(const cell_settings *settings) {
    const mrts_limits limits = {ROWS, row_start, row_column, row_value, settings->lower, settings->upper, row_group,
#if CELL_TURNED
                                base_rotation, triple_axes};
#else
                                0, 0};
#endif
    return limits;
}

/* The largest c^2 that is asked for. */
#if CELL_MOTORS
#define MOST_ASKED(settings) (settings)->most
#else
#define MOST_ASKED(settings) MRTS_INFINITY
#endif

/* Caps c^2 by a limit of which c^2 = 1 takes this share; what is not finite leaves nothing. */
static void cap(mrts_real share, int limit, mrts_real *most, int *binding) {
    if (share * *most <= 1) return;
    *most = share < MRTS_INFINITY ? 1 / share : 0;
    *binding = limit;
}

static mrts_real norm(const mrts_real *vector) { return MRTS_SQRT(mrts_dot(3, vector, vector)); }

/* Caps c^2 by velocities of joints, then of the object, linear and angular, then by ends of torque-speed curves. */
static void cap_velocities(const cell_sample *sample, const mrts_real *limit, mrts_real *most, int *binding) {
    for (int i = 0; i < VELOCITIES; ++i) {
        const int joint = i < JOINTS ? i : END_JOINT(i - JOINTS - 2);
        const mrts_real speed = joint < 0 ? norm(sample->twist + 3 * (i - JOINTS)) : MRTS_ABS(sample->dq[joint]);
        const mrts_real share = speed / limit[i];
        cap(share * share, i, most, binding);
    }
}
#if CELL_MOTIONS

enum { FIRST_POINT = VELOCITIES + JOINTS + 2, FIRST_THING = FIRST_POINT + 2 * CELL_POINTS };

static void cap_accelerations(const cell_sample *sample, const cell_settings *settings, mrts_real *most, int *binding) {
    for (int i = 0; i < JOINTS; ++i) {
        const mrts_real *limit = sample->ddq[i] > 0 ? settings->acceleration_upper : settings->acceleration_lower;
        cap(sample->ddq[i] / limit[i], VELOCITIES + i, most, binding);
    }
    for (int i = 0; i < 2; ++i) {
        cap(norm(sample->acceleration + 3 * i) / settings->object_acceleration[i], VELOCITIES + JOINTS + i, most, binding);
    }
}
#endif
#if CELL_POINTS

static void cap_points(const cell_sample *sample, const cell_settings *settings, mrts_real *most, int *binding) {
    for (int i = 0; i < CELL_POINTS; ++i) {
        mrts_real velocity[3], acceleration[3], place[3];
        const int first = point_first[i];
        const mrts_chain chain = {point_joints[i], joint_axis + 3 * first, joint_point + 3 * first, joint_slides + first};
        for (int j = 0; j < 3; ++j) place[j] = point_place[3 * i + j];
        if (chain.joints > 0) {
            mrts_arm_point(&chain, sample->q + first, sample->dq + first, sample->ddq + first, place, velocity, acceleration);
        } else {
            mrts_object_point(sample->rotation, sample->twist, sample->acceleration, place, velocity, acceleration);
        }
        const mrts_real share = norm(velocity) / settings->point_speed[i];
        cap(share * share, FIRST_POINT + 2 * i, most, binding);
        cap(norm(acceleration) / settings->point_acceleration[i], FIRST_POINT + 2 * i + 1, most, binding);
    }
}
#endif
#if CELL_THINGS

/* Values of c^2 from low to high, high MRTS_INFINITY where nothing bounds it; low is MRTS_INFINITY where there is none. */
typedef struct {
    mrts_real low, high;
} mrts_span;

/* Those >= 0 with slope c^2 + offset <= 0. */
static inline mrts_span mrts_span_below(mrts_real slope, mrts_real offset) {
    mrts_span found = {0, MRTS_INFINITY};
    if (slope > 0) found.high = -offset / slope;
    if (offset > 0) found.low = slope < 0 ? offset / -slope : MRTS_INFINITY;
    return found;
}

/* Those >= 0 with which what a thing takes from the object, s = square c^2 + offset, lies in the cone of its friction:
 * |(s_0, s_1)| <= friction s_2. Of a quadratic a c^4 + 2 b c^2 + d <= 0 that is what lies on the side with s_2 >= 0. */
static inline mrts_span mrts_span_in_cone(const mrts_real *square, const mrts_real *offset, mrts_real friction) {
    const mrts_span nothing = {MRTS_INFINITY, MRTS_INFINITY};
    const mrts_real steep = friction * friction;
    const mrts_real a = mrts_dot(2, square, square) - steep * square[2] * square[2];
    const mrts_real b = mrts_dot(2, square, offset) - steep * square[2] * offset[2];
    const mrts_real d = mrts_dot(2, offset, offset) - steep * offset[2] * offset[2];
    const mrts_real along = square[0] * offset[2] - square[2] * offset[0], across = square[1] * offset[2] - square[2] * offset[1];
    const mrts_real aside = square[0] * offset[1] - square[1] * offset[0];
    const mrts_real lost = MRTS_ZERO * steep * mrts_dot(3, square, square) * mrts_dot(3, offset, offset);
    mrts_real root = steep * (along * along + across * across) - aside * aside; /* b^2 - a d, without cancellation */
    if (root < 0 && root >= -lost) root = 0; /* of a thing that is lifted straight up both are one direction */
    mrts_span found = a == 0 ? mrts_span_below(2 * b, d) : nothing;
    if (a != 0 && root >= 0) {
        const mrts_real sum = b < 0 ? MRTS_SQRT(root) - b : -MRTS_SQRT(root) - b;
        const mrts_real one = sum / a, other = sum != 0 ? d / sum : 0;
        const int rises = a < 0 && square[2] > 0, falls = a < 0 && square[2] < 0;
        found.low = falls ? 0 : rises ? mrts_larger(one, other) : one < other ? one : other;
        found.high = rises ? MRTS_INFINITY : falls ? (one < other ? one : other) : mrts_larger(one, other);
    }
    const mrts_span pressed = mrts_span_below(-square[2], -offset[2]);
    found.low = mrts_larger(mrts_larger(found.low, pressed.low), 0);
    if (pressed.high < found.high) found.high = pressed.high;
    return found.low <= found.high ? found : nothing;
}

static void narrow(mrts_span *span, mrts_span other, int limit, int binding[2]) {
    if (other.low > span->low) {
        span->low = other.low;
        binding[0] = limit;
    }
    if (other.high < span->high && other.low < MRTS_INFINITY) {
        span->high = other.high;
        binding[1] = limit;
    }
}

/* The c^2 with which all things stay as they stand, and which limits set its ends, -1 where none does. */
static mrts_span standing(const cell_sample *sample, const cell_settings *settings, int binding[2]) {
    mrts_span span = {0, MRTS_INFINITY};
    binding[0] = binding[1] = -1;
    for (int i = 0; i < CELL_THINGS; ++i) {
        const int first = FIRST_THING + 5 * i;
        mrts_real velocity[3], acceleration[3], axis[3], square[3], offset[3];
        mrts_object_point(sample->rotation, sample->twist, sample->acceleration, thing_centre + 3 * i, velocity, acceleration);
        for (int j = 0; j < 3; ++j) { /* in its axes it takes square c^2 + offset from the object, per mass */
            for (int k = 0; k < 3; ++k) axis[k] = mrts_dot(3, sample->rotation + 3 * k, thing_axes + 9 * i + 3 * j);
            square[j] = mrts_dot(3, axis, acceleration);
            offset[j] = -mrts_dot(3, axis, gravity);
        }
        if (settings->friction[i] < MRTS_INFINITY) {
            narrow(&span, mrts_span_in_cone(square, offset, settings->friction[i]), first, binding);
        }
        for (int side = 0; side < 4; ++side) {
            const mrts_real tilt = settings->tilt[2 * i + side / 2], sign = side % 2 == 0 ? 1 : -1;
            if (!(tilt < MRTS_INFINITY)) continue;
            narrow(&span, mrts_span_below(sign * square[side / 2] - tilt * square[2], sign * offset[side / 2] - tilt * offset[2]),
                   first + 1 + side, binding);
        }
    }
    return span;
}

static cell_status keep_standing(const cell_sample *sample, const cell_settings *settings, cell_range *range) {
    int binding[2];
    if (range->status != CELL_OK && range->status != CELL_UNBOUNDED) return range->status;
    const mrts_span span = standing(sample, settings, binding);
    if (!(span.low > range->lower)) return range->status;
    range->lower = span.low;
    range->lower_count = 1;
    range->lower_rows[0] = 1 + ROWS + binding[0];
    if (span.low < UNLIKELY && span.low <= range->upper * (1 + MRTS_GAP)) {
        if (range->lower > range->upper) range->lower = range->upper;
        return range->status;
    }
    if (!(span.low < UNLIKELY)) range->upper_count = 0; /* it falls at every speed */
    range->upper_rows[range->upper_count++] = range->lower_rows[0];
    range->lower = range->upper = 0;
    range->lower_count = 0;
    return range->status = CELL_INFEASIBLE;
}
#else
#define keep_standing(sample, settings, range) (range)->status
#endif

/* Largest c^2 that limits of the motion alone allow, or that is `asked` for, MRTS_INFINITY if none bounds it, -1 if a limit is
 * not > 0; `named` is the one that sets it, as in cell_range, 0 if none does. */
static mrts_real motion_cap(const cell_sample *sample, const cell_settings *settings, mrts_real asked, int *named) {
    mrts_real most = MRTS_INFINITY;
    int binding = -1;
    *named = 0;
    if (!has_sound_motions(settings)) return -1;
    cap_velocities(sample, settings->velocity, &most, &binding);
#if CELL_MOTIONS
    cap_accelerations(sample, settings, &most, &binding);
#endif
#if CELL_POINTS
    cap_points(sample, settings, &most, &binding);
#endif
#if CELL_THINGS
    int ends[2];
    const mrts_span span = standing(sample, settings, ends);
    if (span.high < most) {
        most = span.high;
        binding = ends[1];
    }
#endif
    if (!(asked > 0)) return -1;
    if (asked <= most) return asked;
    if (!(most < UNLIKELY)) return asked < MRTS_INFINITY ? asked : MRTS_INFINITY;
    *named = 1 + ROWS + binding;
    return most;
}

#if CELL_MOTORS
/* What motors add at a sample, in the workspace: to torques and rows with the speed c at a value, what c adds to each of
 * them, and by how much dry friction in both directions narrows limits. */
static mrts_terms motor_terms(const cell_sample *sample, const cell_settings *settings, mrts_real speed,
                              cell_workspace *workspace) {
    const mrts_terms terms = {workspace->torque_square, workspace->torque_offset, 0,                   workspace->row_offset,
                              workspace->row_margin,    workspace->torque_speed,  workspace->row_speed};
    mrts_real turning[JOINTS];
    for (int joint = 0; joint < JOINTS; ++joint) {
        const mrts_real viscous = settings->viscous[joint] * sample->dq[joint];
        workspace->torque_square[joint] = settings->armature[joint] * sample->ddq[joint];
        workspace->torque_offset[joint] = dry_friction(sample, settings, joint, &turning[joint]) + viscous * speed;
        workspace->torque_speed[joint] = viscous;
    }
    for (int row = 0; row < ROWS; ++row) {
        workspace->row_margin[row] = workspace->row_speed[row] = 0;
        for (int entry = row_start[row]; entry < row_start[row + 1]; ++entry) {
            const int joint = row_column[entry];
            if (joint < JOINTS) workspace->row_margin[row] += MRTS_ABS(row_value[entry]) * turning[joint];
        }
    }
#if CELL_LINES
    for (int line = 0; line < CELL_LINES; ++line) {
        workspace->row_speed[line_row[line]] = settings->slope[line] * sample->dq[line_joint[line]];
    }
#endif
    for (int row = 0; row < ROWS; ++row) workspace->row_offset[row] = workspace->row_speed[row] * speed;
    return terms;
}
#endif

/* Rows of the limits in `unknowns` unknowns of a form, in the workspace; 0 if limits are reversed or a number is not finite.
 * What motors add at the speed c is in them. */
static int build_rows(const cell_sample *sample, const cell_settings *settings, mrts_real c2, int unknowns, mrts_form *form,
                      cell_workspace *workspace, mrts_rows *rows) {
    const mrts_limits limits = limits_of(settings);
#if CELL_MOTORS
    const mrts_terms terms = motor_terms(sample, settings, MRTS_SQRT(c2), workspace);
    mrts_add_motors(unknowns, JOINTS, &terms, form);
    if ((int)sample->place < 0 || sample->place > CELL_END || !all_finite(JOINTS, terms.torque_square) ||
        !all_finite(JOINTS, terms.torque_offset) || !all_finite(JOINTS, terms.torque_speed) ||
        !all_finite(ROWS, terms.offset) || !all_finite(ROWS, terms.margin) || !all_finite(ROWS, terms.speed)) {
        return 0;
    }
#else
    static const mrts_terms terms = {0, 0, 0, 0, 0, 0, 0};
    (void)c2;
#endif
#if CELL_TURNED
    mrts_real *turned = workspace->turned;
#else
    mrts_real *turned = 0; /* no row is in object axes */
#endif
    mrts_turn_wrenches(unknowns, CELL_ROBOTS, CELL_WRENCH, &limits, sample->rotation, 3, 1, turned, form);
    return mrts_rows_over(unknowns, &limits, workspace->rows, workspace->which, rows) &&
           mrts_build_rows(unknowns, JOINTS, WRENCHES, form, &limits, &terms, rows);
}

static mrts_form wrench_form(const cell_sample *sample, const mrts_real *load, cell_workspace *workspace) {
    mrts_real turned[9];
    const mrts_real *arg[7];
    const mrts_form form = mrts_form_in(K, JOINTS, WRENCHES, workspace->form);
    mrts_real *const res[] = {form.torque_map, form.torque_offset, form.wrench_map, form.wrench_offset};
    point_to(sample, load, turned, arg);
    cell_model_wrench_form(arg, res);
    return form;
}

#if CELL_MOTORS
/* What the speed c adds to each of the rows just built, in the workspace; whether that is anything. */
static int has_speed_terms(const cell_settings *settings, const mrts_rows *rows, cell_workspace *workspace) {
    const mrts_limits limits = limits_of(settings);
    const mrts_terms terms = {0, 0, 0, 0, 0, workspace->torque_speed, workspace->row_speed};
    mrts_speed_column(JOINTS, &limits, &terms, rows, workspace->by_speed);
    for (int i = 0; i < rows->count; ++i) {
        if (workspace->by_speed[i] != 0) return 1;
    }
    return 0;
}
#endif

#define BINDING MRTS_EITHER(1e-7, 1e-4) /* a row binds if its multiplier exceeds this share of the largest */

/* A row of the programs as cell_range names it; `velocity` bounds c^2 by itself. */
static int name_of(int code, int at_lower, const mrts_rows *rows, int velocity) {
    const int row = (code < 0 ? -code : code) - 1;
    if (row >= rows->count) return at_lower ? 0 : velocity;
    return at_lower ? -rows->which[row] - 1 : rows->which[row] + 1;
}

/* Rows with a multiplier, the strongest first; returns how many. The side is that of the basis, or of a certificate's
 * multiplier. */
static int name_rows(int k, const int *basis, const mrts_real *y, const mrts_rows *rows, int velocity, int by_sign,
                     int *named) {
    mrts_real largest = 0, strength[K];
    int count = 0;
    for (int j = 0; j < k; ++j) largest = mrts_larger(largest, MRTS_ABS(y[j]));
    for (int j = 0; j < k; ++j) {
        const mrts_real its = MRTS_ABS(y[j]);
        if (its <= BINDING * largest) continue;
        int at = count++;
        for (; at > 0 && its > strength[at - 1]; --at) {
            strength[at] = strength[at - 1];
            named[at] = named[at - 1];
        }
        strength[at] = its;
        named[at] = name_of(basis[j], by_sign ? y[j] > 0 : basis[j] < 0, rows, velocity);
    }
    return count;
}

/* A kept basis that does not fit these rows starts cold. */
static void check_basis(int k, int *basis, int rows) {
    if (basis[0] == 0) return;
    for (int j = 0; j < k; ++j) {
        if (basis[j] == 0 || mrts_abs(basis[j]) > rows + k) {
            basis[0] = 0;
            return;
        }
    }
}

/* The least (sign 1) or the largest c^2, the last of k unknowns, of scaled rows, and what sets it or conflicts. */
static cell_status solve_end(int k, const mrts_rows *rows, int velocity, mrts_real sign, int *basis, mrts_real column,
                             cell_workspace *workspace, mrts_real *end, int *count, int *named) {
    mrts_real g[K], x[K], y[K];
    int entering = 0;
    for (int j = 0; j < k; ++j) g[j] = j == k - 1 ? sign : 0;
    check_basis(k, basis, rows->count);
    const int status = mrts_lp_again(k, rows->count, rows->A, rows->lower, rows->upper, g, basis, x, y, &entering,
                                     workspace->work, workspace->integers);
    if (status == MRTS_INFEASIBLE) {
        named[0] = name_of(entering, entering < 0, rows, velocity);
        *count = name_rows(k, basis, y, rows, velocity, 1, named + 1) + 1;
        basis[0] = 0;
        return CELL_INFEASIBLE;
    }
    if (status != MRTS_OPTIMAL) {
        basis[0] = 0;
        *count = 0;
        return CELL_UNDECIDED;
    }
    *end = x[k - 1] * column;
    if (*end < 0) *end = 0;
    if (sign < 0 && !velocity && x[k - 1] >= MRTS_UNBOUNDED * (1 - 10 * MRTS_FEASIBLE)) return CELL_UNBOUNDED;
    *count = name_rows(k, basis, y, rows, velocity, 0, named);
    return CELL_OK;
}

#if CELL_MOTORS
/* An infeasible sample is so at standstill too: the rows that conflict there. */
static cell_status conflict_at_rest(int k, mrts_rows *rows, cell_range *range, cell_workspace *workspace) {
    mrts_real column[K], end;
    int basis[K];
    for (int i = 0; i < rows->count; ++i) rows->A[i * k + k - 1] = 0;
    mrts_scale_columns(k, rows, column);
    mrts_bound_speed(k, 0, column, rows);
    basis[0] = 0;
    range->status = solve_end(k, rows, 0, 1, basis, column[k - 1], workspace, &end, &range->upper_count, range->upper_rows);
    if (range->status == CELL_INFEASIBLE) return range->status;
    range->upper_count = 0;
    return range->status = CELL_UNDECIDED;
}

/* An end of an interval more exactly, and what binds there: the furthest point (sign -1: upwards) on the tangent of the
 * curve (c^2, c) at that end, along which the rows have one unknown of speed only, as ranges without such terms. */
static void name_end(const mrts_curve *curve, mrts_rows *rows, mrts_real most, int fastest, mrts_real sign, int *basis,
                     cell_workspace *workspace, mrts_real *end, int *count, int *named) {
    const int k = curve->n - 1, f = k - 1;
    const mrts_real at = *end, shift = at * at;
    mrts_real column[K], found = at;
    for (int i = 0; i < rows->count; ++i) {
        const mrts_real *row = curve->A + i * curve->n;
        for (int j = 0; j < f; ++j) rows->A[i * k + j] = row[j];
        rows->A[i * k + f] = 2 * at * row[f] + row[k];
        rows->lower[i] = curve->lower[i] > -MRTS_INFINITY ? curve->lower[i] + row[f] * shift : -MRTS_INFINITY;
        rows->upper[i] = curve->upper[i] < MRTS_INFINITY ? curve->upper[i] + row[f] * shift : MRTS_INFINITY;
    }
    mrts_scale_columns(k, rows, column);
    mrts_bound_speed(k, most, column, rows);
    const int velocity = most / column[f] < MRTS_UNBOUNDED ? fastest : 0;
    if (solve_end(k, rows, velocity, sign, basis, column[f], workspace, &found, count, named) != CELL_OK) *count = 0;
    if (MRTS_ABS(found - at) <= MRTS_SMALL * at) *end = found;
}

/* The range of rows with terms in c over k unknowns, c^2 last: the interval that ends at the largest c^2. Programs start
 * from bases and a speed, of which they become those of this range. */
static cell_status range_of_speed(int k, mrts_rows *rows, mrts_real most, int fastest, int *basis, mrts_real *speed,
                                  cell_range *range, cell_workspace *workspace) {
    mrts_real column[K], end_dual[2 * (K + 1)];
    int end_basis[2 * (K + 1)], *of_curve = basis + 2 * k;
    mrts_curve_ends start = {0, of_curve, end_basis, end_dual};
    mrts_interval found;
    mrts_curve curve;
    for (int i = 0; i < MRTS_CURVE_BASES; ++i) check_basis(k + 1, of_curve + i * (k + 1), rows->count + 1);
    mrts_scale_columns(k, rows, column);
    const mrts_real square =
        mrts_curve_over(k, rows, column, workspace->by_speed, workspace->curve, workspace->curve_integers, &curve);
    const mrts_real unit = square > 0 ? MRTS_SQRT(square) : 1;
    const mrts_real reach = most < MRTS_INFINITY ? MRTS_SQRT(most) / unit : MRTS_INFINITY;
    if (*speed > 0 && *speed < MRTS_INFINITY) start.speed = *speed / unit;
    const int status = mrts_highest_interval(&curve, reach, &start, &found);
    *speed = start.speed * unit;
    if (status == MRTS_INFEASIBLE) return conflict_at_rest(k, rows, range, workspace);
    if (status != MRTS_OPTIMAL) return range->status = CELL_UNDECIDED;
    if (found.low <= MRTS_FEASIBLE) found.low = 0; /* that moves no row by more than rounding */
    range->status = found.high < MRTS_INFINITY || most < MRTS_INFINITY ? CELL_OK : CELL_UNBOUNDED;
    range->lower_count = 1;
    range->lower_rows[0] = 0;
    if (found.low > 0) {
        name_end(&curve, rows, reach, fastest, 1, basis, workspace, &found.low, &range->lower_count, range->lower_rows);
    }
    range->upper_count = fastest != 0;
    range->upper_rows[0] = fastest;
    if (found.high < MRTS_INFINITY) {
        name_end(&curve, rows, reach, fastest, -1, basis + k, workspace, &found.high, &range->upper_count,
                 range->upper_rows);
    }
    range->lower = found.low * unit * (found.low * unit);
    range->upper = found.high < MRTS_INFINITY ? found.high * unit * (found.high * unit) : most;
    return range->status;
}
#endif

static cell_status range_with_load(const cell_sample *sample, const cell_settings *settings, mrts_real asked,
                                   const mrts_real *load, cell_range *range, cell_workspace *workspace) {
    mrts_real column[K];
    mrts_rows rows;
    int fastest;
    range->lower = range->upper = 0;
    range->lower_count = range->upper_count = 0;
    if (!is_sound(sample, load)) return range->status = CELL_BAD_ARGUMENT;
    const mrts_real most = motion_cap(sample, settings, asked, &fastest);
    mrts_form form = wrench_form(sample, load, workspace);
    if (most < 0 || !build_rows(sample, settings, 0, K, &form, workspace, &rows)) {
        return range->status = CELL_BAD_ARGUMENT;
    }
#if CELL_MOTORS
    if (has_speed_terms(settings, &rows, workspace)) {
        return range_of_speed(K, &rows, most, fastest, workspace->basis, &workspace->curve_speed, range, workspace);
    }
#endif
    mrts_scale_columns(K, &rows, column);
    mrts_bound_speed(K, most, column, &rows);
    const int velocity = most / column[F] < MRTS_UNBOUNDED ? fastest : 0;
    const int at_rest = 1 <= NO_EFFECT * column[F] || rows.size[F] == 0;
    for (int i = 0; at_rest && i < rows.count; ++i) rows.A[i * K + F] = 0;
    range->status = solve_end(K, &rows, velocity, 1, workspace->basis, column[F], workspace, &range->lower,
                              &range->lower_count, range->lower_rows);
    if (range->status != CELL_OK) {
        range->upper_count = range->lower_count;
        for (int i = 0; i < range->lower_count; ++i) range->upper_rows[i] = range->lower_rows[i];
        range->lower_count = 0;
        return range->status;
    }
    if (!at_rest) {
        range->status = solve_end(K, &rows, velocity, -1, workspace->basis + K, column[F], workspace, &range->upper,
                                  &range->upper_count, range->upper_rows);
    }
    if (at_rest || range->status == CELL_UNBOUNDED) { /* only velocities bound c^2 */
        range->upper = most;
        range->upper_count = fastest != 0;
        range->upper_rows[0] = fastest;
        range->status = most < MRTS_INFINITY ? CELL_OK : CELL_UNBOUNDED;
    }
    return range->status;
}

cell_status cell_range_of_sample(const cell_sample *sample, const cell_settings *settings, cell_range *range,
                                 cell_workspace *workspace) {
    range_with_load(sample, settings, MOST_ASKED(settings), settings->load, range, workspace);
    return keep_standing(sample, settings, range);
}

#if CELL_MOTORS
enum { MOST_TURNS = 64 }; /* intervals that are left for slower ones */
#endif

/* What the ranges of all loads up to a c^2 have in common, and the loads that set its ends. */
static cell_status range_in_common(const cell_sample *sample, const cell_settings *settings, mrts_real asked,
                                   const mrts_real (*loads)[CELL_LOAD], int count, cell_range *range, int *lower_load,
                                   int *upper_load, cell_workspace *workspace) {
    cell_range one;
    *lower_load = *upper_load = 0;
    for (int load = 0; load < count; ++load) {
        const cell_status status = range_with_load(sample, settings, asked, loads[load], &one, workspace);
        if (load == 0) *range = one;
        if (status != CELL_OK && status != CELL_UNBOUNDED) {
            *range = one;
            *lower_load = *upper_load = load;
            break;
        }
        if (one.lower > range->lower) {
            range->lower = one.lower;
            range->lower_count = one.lower_count;
            for (int i = 0; i < one.lower_count; ++i) range->lower_rows[i] = one.lower_rows[i];
            *lower_load = load;
        }
        if (one.upper < range->upper) {
            range->upper = one.upper;
            range->status = one.status;
            range->upper_count = one.upper_count;
            for (int i = 0; i < one.upper_count; ++i) range->upper_rows[i] = one.upper_rows[i];
            *upper_load = load;
        }
    }
    if (range->status == CELL_OK && range->lower > range->upper) range->status = CELL_EMPTY;
    return keep_standing(sample, settings, range);
}

cell_status cell_guaranteed_range(const cell_sample *sample, const cell_settings *settings,
                                  const mrts_real (*loads)[CELL_LOAD], int count, cell_range *range, int *lower_load,
                                  int *upper_load, cell_workspace *workspace) {
    int at_lower, at_upper;
    if (count < 1) return range->status = CELL_BAD_ARGUMENT;
    range_in_common(sample, settings, MOST_ASKED(settings), loads, count, range, &at_lower, &at_upper, workspace);
#if CELL_MOTORS
    for (int turn = 0; turn < MOST_TURNS && range->status == CELL_EMPTY; ++turn) { /* slower intervals may have one */
        cell_range slower;
        int low, high;
        const mrts_real asked = range->upper * (1 + MRTS_GAP); /* so that what sets it is named */
        range_in_common(sample, settings, asked, loads, count, &slower, &low, &high, workspace);
        if (slower.status != CELL_OK && slower.status != CELL_EMPTY) break;
        *range = slower;
        at_lower = low;
        at_upper = high;
    }
#endif
    if (lower_load != 0) *lower_load = at_lower;
    if (upper_load != 0) *upper_load = at_upper;
    return range->status;
}

static cell_status share_range(const cell_sample *sample, const cell_settings *settings, cell_range *range,
                               cell_workspace *workspace) {
    mrts_real turned[9], shares[CELL_ROBOTS], internal[WRENCHES];
    const mrts_real *arg[9];
    mrts_form form = mrts_form_in(1, JOINTS, WRENCHES, workspace->form);
    mrts_real *const res[] = {form.torque_map, form.torque_offset, form.wrench_map, form.wrench_offset};
    mrts_rows rows;
    int fastest;
    range->lower = range->upper = 0;
    range->lower_count = range->upper_count = 0;
    if (!is_sound(sample, settings->load)) return range->status = CELL_BAD_ARGUMENT;
    for (int i = 0; i < CELL_ROBOTS; ++i) shares[i] = (mrts_real)1 / CELL_ROBOTS;
    for (int i = 0; i < WRENCHES; ++i) internal[i] = 0;
    point_to(sample, settings->load, turned, arg);
    arg[7] = shares;
    arg[8] = internal;
    cell_model_fixed_distribution(arg, res);
    const mrts_real most = motion_cap(sample, settings, MOST_ASKED(settings), &fastest);
    if (most < 0 || !build_rows(sample, settings, 0, 1, &form, workspace, &rows)) {
        return range->status = CELL_BAD_ARGUMENT;
    }
#if CELL_MOTORS
    if (has_speed_terms(settings, &rows, workspace)) {
        int basis[2 + 2 * MRTS_CURVE_BASES] = {0};
        mrts_real speed = 0;
        return range_of_speed(1, &rows, most, fastest, basis, &speed, range, workspace);
    }
#endif
    range->lower = 0;
    range->upper = most;
    range->lower_count = 1;
    range->lower_rows[0] = 0;
    range->upper_count = fastest != 0;
    range->upper_rows[0] = fastest;
    for (int i = 0; i < rows.count; ++i) {
        const mrts_real a = rows.A[i], lower = rows.lower[i], upper = rows.upper[i];
        const int forward = a > 0, at_lower = -rows.which[i] - 1, at_upper = rows.which[i] + 1;
        if (MRTS_ABS(a) <= NO_EFFECT) {
            if (lower <= MRTS_FEASIBLE && upper >= -MRTS_FEASIBLE) continue;
            range->upper_rows[0] = lower > 0 ? at_lower : at_upper;
            range->upper_count = 1;
            return range->status = CELL_INFEASIBLE;
        }
        const mrts_real from = forward ? lower : upper, to = forward ? upper : lower;
        if (from > -MRTS_INFINITY && from < MRTS_INFINITY && from / a > range->lower) {
            range->lower = from / a;
            range->lower_rows[0] = forward ? at_lower : at_upper;
        }
        if (to > -MRTS_INFINITY && to < MRTS_INFINITY && to / a < range->upper) {
            range->upper = to / a;
            range->upper_rows[0] = forward ? at_upper : at_lower;
            range->upper_count = 1;
        }
    }
    if (range->lower > range->upper) {
        range->upper_rows[1] = range->lower_rows[0];
        range->upper_count = 2;
        return range->status = CELL_INFEASIBLE;
    }
    return range->status = range->upper < MRTS_INFINITY ? CELL_OK : CELL_UNBOUNDED;
}

cell_status cell_equal_share_range(const cell_sample *sample, const cell_settings *settings, cell_range *range,
                                   cell_workspace *workspace) {
    share_range(sample, settings, range, workspace);
    return keep_standing(sample, settings, range);
}

#define TORQUE_WIDENING MRTS_EITHER(1e-9, 1e-5) /* of limits: at the end of a range the feasible set is a point */

cell_status cell_torques(const cell_sample *sample, const cell_settings *settings, mrts_real c2,
                         mrts_real torque[CELL_JOINTS], mrts_real wrench[CELL_WRENCHES], cell_workspace *workspace) {
    const mrts_limits limits = limits_of(settings);
    mrts_real H[K * K], g[K], x[K], u[K], column[K], weighted[JOINTS];
    mrts_rows rows;
    int active[K], count, fastest;
    for (int i = 0; i < JOINTS; ++i) torque[i] = 0;
    for (int i = 0; i < WRENCHES; ++i) wrench[i] = 0;
    if (!(c2 >= 0 && c2 < MRTS_INFINITY) || !is_sound(sample, settings->load)) return CELL_BAD_ARGUMENT;
    const mrts_real most = motion_cap(sample, settings, MOST_ASKED(settings), &fastest);
    mrts_form form = wrench_form(sample, settings->load, workspace);
    if (most < 0 || !build_rows(sample, settings, c2, K, &form, workspace, &rows)) return CELL_BAD_ARGUMENT;
    const mrts_weights weights = {settings->weight, 1};
    mrts_torque_program(K, JOINTS, WRENCHES, &limits, &weights, c2, TORQUE_WIDENING, &form, &rows, H, g, column, weighted,
                        torque, wrench);
    for (int j = 0; j < F; ++j) x[j] = 0;
    int status = mrts_qp(F, rows.count, H, rows.A, rows.lower, rows.upper, g, x, active, u, &count, workspace->work,
                         workspace->integers);
    mrts_add_free(K, JOINTS, WRENCHES, &form, column, x, torque, wrench);
    if (c2 > most * (1 + 2 * TORQUE_WIDENING)) status = MRTS_INFEASIBLE;
#if CELL_THINGS
    int ends[2];
    if (c2 < standing(sample, settings, ends).low * (1 - 2 * TORQUE_WIDENING)) status = MRTS_INFEASIBLE;
#endif
    if (!all_finite(JOINTS, torque) || !all_finite(WRENCHES, wrench)) return CELL_UNDECIDED;
    return status == MRTS_OPTIMAL ? CELL_OK : status == MRTS_INFEASIBLE ? CELL_INFEASIBLE : CELL_UNDECIDED;
}
