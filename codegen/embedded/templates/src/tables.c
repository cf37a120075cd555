/* @NOTICE@
 * The numbers and names of the cell. */
#include "@NAME@_internal.h"

static const char *const ROW_TEXT[1 + @MACRO@_ROWS + @MACRO@_VELOCITIES] = {
    "c^2 >= 0",
@ROW_TEXT@
};

const int @NAME@_row_start[@MACRO@_ROWS + 1] = {@ROW_START@};
const int @NAME@_row_column[@ENTRIES@] = {@ROW_COLUMN@};
const mrts_real @NAME@_row_value[@ENTRIES@] = {@ROW_VALUE@};
const int @NAME@_row_group[@MACRO@_ROWS] = {@ROW_GROUP@};

const char *@NAME@_row_text(int row) {
    const int place = row < 0 ? -row : row;
    return place <= ROWS + VELOCITIES ? ROW_TEXT[place] : "unknown row";
}

void @NAME@_default_settings(@NAME@_settings *settings) {
    static const @NAME@_settings defaults = {
        {@LOAD@},
        {@LOWER@},
        {@UPPER@},
        {@VELOCITY@},
        {@WEIGHT@},
    };
    *settings = defaults;
}
