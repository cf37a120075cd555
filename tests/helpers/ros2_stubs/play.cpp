// Takes the controller of docs/ros2.md through a plan: off its start, at its start, at half the speed, to a stop, to the end.
#include "override_controller.cpp"

using Interface = controller_interface::LoanedInterface;

int main() {
    const double dt = 0.001;
    const dual_ur5_plan_node *nodes = dual_ur5_planned.nodes, *last = nodes + dual_ur5_planned.count - 1;
    double measured[DUAL_UR5_JOINTS], commanded[DUAL_UR5_JOINTS][2];
    dual_ur5::OverrideController controller;
    controller.on_init();
    auto node = controller.get_node();
    if (controller.on_configure({}) != controller_interface::CallbackReturn::ERROR) return 1;  // no joints
    node->parameters["joints"].value = std::vector<std::string>(DUAL_UR5_JOINTS, "joint");
    if (controller.on_configure({}) != controller_interface::CallbackReturn::SUCCESS) return 2;
    if (controller.command_interface_configuration().names.size() != 2 * DUAL_UR5_JOINTS) return 3;
    for (int j = 0; j < DUAL_UR5_JOINTS; ++j) {
        measured[j] = nodes->q[j] + 0.1;
        controller.state_interfaces_.push_back(Interface{&measured[j]});
        for (double & number : commanded[j]) controller.command_interfaces_.push_back(Interface{&number});
    }
    if (controller.on_activate({}) != controller_interface::CallbackReturn::ERROR) return 4;  // off the path
    for (int j = 0; j < DUAL_UR5_JOINTS; ++j) measured[j] = nodes->q[j] + 0.001;
    if (controller.on_activate({}) != controller_interface::CallbackReturn::SUCCESS) return 5;
    auto knob = std::static_pointer_cast<rclcpp::Subscription<std_msgs::msg::Float64>>(node->subscription);
    const double wanted[] = {0.0, 0.5, NAN, 0.0, 1.0};
    for (int part = 0; part < 5; ++part) {
        double before = 0;
        knob->received({wanted[part]});
        for (int tick = 0; tick < (part < 4 ? 100 : 3000); ++tick) {
            before = commanded[0][0];
            if (controller.update({}, {dt}) != controller_interface::return_type::OK) return 6;
        }
        if ((commanded[0][0] == before) != (wanted[part] == 0 || part == 4)) return 7;  // stands still, or moves
    }
    for (int j = 0; j < DUAL_UR5_JOINTS; ++j) {
        if (commanded[j][0] != last->q[j]) return 8;
    }
    for (double torque : {commanded[0][1], commanded[1][1]}) std::printf("%.17g\n", torque);
    return 0;
}
