/* Range of c^2 where every arm carries an equal share of the load: closed form, one row at a time. */
@NAME@_status @NAME@_equal_share_range(const @NAME@_sample *sample, const @NAME@_settings *settings,
                                   @NAME@_range *range, @NAME@_workspace *workspace);
