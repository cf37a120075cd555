#pragma once
#include "controller_interface/controller_interface.hpp"
