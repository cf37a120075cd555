    settings.rest_speed = @MACRO@_REST_SPEED;
    settings.rest_acceleration = @MACRO@_REST_ACCELERATION;
