/* Least and largest c^2 at a sample, torques distributed freely. */
@NAME@_status @NAME@_range_of_sample(const @NAME@_sample *sample, const @NAME@_settings *settings, @NAME@_range *range,
                         @NAME@_workspace *workspace);

/* The same for every load of a list at once: the intersection. For the corners of a box that is the range guaranteed
 * for every load of the box. `lower_load` and `upper_load` (or null) become the loads that set the ends. */
@NAME@_status @NAME@_guaranteed_range(const @NAME@_sample *sample, const @NAME@_settings *settings,
                                  const @NAME@_real (*loads)[@MACRO@_LOAD], int count, @NAME@_range *range,
                                  int *lower_load, int *upper_load, @NAME@_workspace *workspace);

/* Corners of the cell file's load variation. */
extern const @NAME@_real @NAME@_load_corners[@MACRO@_CORNERS][@MACRO@_LOAD];
