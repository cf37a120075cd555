// What docs/ros2.md uses of ros2_control and rclcpp, with their names and signatures; interfaces are numbers in memory.
#pragma once
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#define RCLCPP_ERROR(logger, ...) ((void)(logger), std::fprintf(stderr, __VA_ARGS__))

namespace rclcpp {
struct Time {};
struct Logger {};
struct SystemDefaultsQoS {};
struct Duration {
    double given;
    double seconds() const { return given; }
};
template <class Message>
struct Subscription {
    using SharedPtr = std::shared_ptr<Subscription>;
    std::function<void(const Message &)> received;
};
struct Parameter {
    std::variant<double, std::vector<std::string>> value;
    double as_double() const { return std::get<double>(value); }
    std::vector<std::string> as_string_array() const { return std::get<std::vector<std::string>>(value); }
};
}  // namespace rclcpp

namespace rclcpp_lifecycle {
struct State {};
struct LifecycleNode {
    std::map<std::string, rclcpp::Parameter> parameters;
    std::shared_ptr<void> subscription;
    rclcpp::Logger get_logger() const { return {}; }
    rclcpp::Parameter get_parameter(const std::string & name) const { return parameters.at(name); }
    template <class Message>
    auto create_subscription(const std::string &, rclcpp::SystemDefaultsQoS, std::function<void(const Message &)> received) {
        auto made = std::make_shared<rclcpp::Subscription<Message>>(rclcpp::Subscription<Message>{received});
        subscription = made;
        return made;
    }
};
}  // namespace rclcpp_lifecycle

namespace controller_interface {
enum class CallbackReturn { SUCCESS, FAILURE, ERROR };
enum class return_type { OK, ERROR };
enum class interface_configuration_type { ALL, INDIVIDUAL, NONE };
struct InterfaceConfiguration {
    interface_configuration_type type;
    std::vector<std::string> names;
};
struct LoanedInterface {
    double * number;
    [[nodiscard]] bool set_value(const double & value) { return *number = value, true; }
    [[nodiscard]] std::optional<double> get_optional() const { return *number; }
};

class ControllerInterface {
public:
    virtual ~ControllerInterface() = default;
    virtual CallbackReturn on_init() = 0;
    virtual InterfaceConfiguration command_interface_configuration() const = 0;
    virtual InterfaceConfiguration state_interface_configuration() const = 0;
    virtual CallbackReturn on_configure(const rclcpp_lifecycle::State &) = 0;
    virtual CallbackReturn on_activate(const rclcpp_lifecycle::State &) = 0;
    virtual return_type update(const rclcpp::Time &, const rclcpp::Duration &) = 0;
    std::shared_ptr<rclcpp_lifecycle::LifecycleNode> get_node() { return node_; }

    std::vector<LoanedInterface> command_interfaces_, state_interfaces_;  // loaned by tests

protected:
    template <class Value>
    void auto_declare(const std::string & name, const Value & value) {
        node_->parameters.emplace(name, rclcpp::Parameter{value});
    }

private:
    std::shared_ptr<rclcpp_lifecycle::LifecycleNode> node_ = std::make_shared<rclcpp_lifecycle::LifecycleNode>();
};
}  // namespace controller_interface
