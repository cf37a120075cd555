// Plays the plan of `mrts export --plan` at the speed that ~/wanted_speed asks for: all arms, one clock, all limits.
#include <atomic>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "controller_interface/controller_interface.hpp"
#include "dual_ur5_override.h"
#include "pluginlib/class_list_macros.hpp"
#include "rclcpp/rclcpp.hpp"
#include "std_msgs/msg/float64.hpp"

namespace dual_ur5 {

using controller_interface::CallbackReturn;
using controller_interface::InterfaceConfiguration;
using controller_interface::interface_configuration_type;

class OverrideController : public controller_interface::ControllerInterface {
public:
    CallbackReturn on_init() override {
        auto_declare<std::vector<std::string>>("joints", {});  // in the order of the cell file
        auto_declare<double>("within", 0.01);                  // of the path, where it is activated [rad or m]
        return CallbackReturn::SUCCESS;
    }

    InterfaceConfiguration command_interface_configuration() const override {
        return {interface_configuration_type::INDIVIDUAL, interfaces({"/position", "/effort"})};
    }

    InterfaceConfiguration state_interface_configuration() const override {
        return {interface_configuration_type::INDIVIDUAL, interfaces({"/position"})};
    }

    CallbackReturn on_configure(const rclcpp_lifecycle::State &) override {
        joints_ = get_node()->get_parameter("joints").as_string_array();
        if (joints_.size() != DUAL_UR5_JOINTS) {
            RCLCPP_ERROR(get_node()->get_logger(), "the plan has %d joints, not %zu", DUAL_UR5_JOINTS, joints_.size());
            return CallbackReturn::ERROR;
        }
        subscription_ = get_node()->create_subscription<std_msgs::msg::Float64>(
            "~/wanted_speed", rclcpp::SystemDefaultsQoS(), [this](const std_msgs::msg::Float64 & message) {
                if (std::isfinite(message.data)) wanted_ = message.data;
            });
        return CallbackReturn::SUCCESS;
    }

    // Stands on the path where the joints are, at its start or where a stop left them, until a speed is asked for.
    CallbackReturn on_activate(const rclcpp_lifecycle::State &) override {
        const double within = get_node()->get_parameter("within").as_double();
        dual_ur5_real q[DUAL_UR5_JOINTS];
        for (int j = 0; j < DUAL_UR5_JOINTS; ++j) {
            q[j] = state_interfaces_[j].get_optional().value_or(std::numeric_limits<double>::quiet_NaN());
        }
        if (dual_ur5_override_resume(&dual_ur5_planned, q, within, &state_) != DUAL_UR5_OK) {
            RCLCPP_ERROR(get_node()->get_logger(), "a joint is farther than %g from the path", within);
            return CallbackReturn::ERROR;
        }
        wanted_ = 0.0;
        return CallbackReturn::SUCCESS;
    }

    controller_interface::return_type update(const rclcpp::Time &, const rclcpp::Duration & period) override {
        bool sent = dual_ur5_override_step(&dual_ur5_planned, wanted_, period.seconds(), &state_) == DUAL_UR5_OK;
        for (int j = 0; j < DUAL_UR5_JOINTS; ++j) {
            sent &= command_interfaces_[2 * j].set_value(static_cast<double>(state_.q[j]));
            sent &= command_interfaces_[2 * j + 1].set_value(static_cast<double>(state_.torque[j]));
        }
        return sent ? controller_interface::return_type::OK : controller_interface::return_type::ERROR;
    }

private:
    std::vector<std::string> interfaces(const std::vector<std::string> & kinds) const {
        std::vector<std::string> names;
        for (const auto & joint : joints_) {
            for (const auto & kind : kinds) names.push_back(joint + kind);
        }
        return names;
    }

    std::vector<std::string> joints_;
    std::atomic<double> wanted_{0.0};
    dual_ur5_override state_{};
    rclcpp::Subscription<std_msgs::msg::Float64>::SharedPtr subscription_;
};

}  // namespace dual_ur5

PLUGINLIB_EXPORT_CLASS(dual_ur5::OverrideController, controller_interface::ControllerInterface)
