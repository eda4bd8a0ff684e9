/* As much of ROS 2 as the node uses, so that it compiles and a test can send it messages. */
#pragma once
#include <any>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace rcl_interfaces::msg {
struct SetParametersResult {
    bool successful;
    std::string reason;
};
}  // namespace rcl_interfaces::msg

namespace sensor_msgs::msg {
struct JointState {
    using SharedPtr = std::shared_ptr<JointState>;
    struct {
        double stamp;
    } header;
    std::vector<std::string> name;
    std::vector<double> position, velocity, effort;
};
}  // namespace sensor_msgs::msg

namespace std_msgs::msg {
struct Float64 {
    using SharedPtr = std::shared_ptr<Float64>;
    double data;
};
struct Float64MultiArray {
    struct Dimension {
        std::string label;
        std::uint32_t size, stride;
    };
    struct {
        std::vector<Dimension> dim;
    } layout;
    std::vector<double> data;
};
}  // namespace std_msgs::msg

namespace std_srvs::srv {
struct Trigger {
    struct Request {
        using SharedPtr = std::shared_ptr<Request>;
    };
    struct Response {
        using SharedPtr = std::shared_ptr<Response>;
        bool success;
    };
};
}  // namespace std_srvs::srv

namespace rclcpp {
struct Time {
    explicit Time(double stamp) : stamp_(stamp) {}
    double seconds() const { return stamp_; }
    double stamp_;
};
class Parameter {
public:
    Parameter(std::string name, std::variant<double, std::string> value) : name_(name), value_(value) {}
    const std::string &get_name() const { return name_; }
    double as_double() const { return std::get<double>(value_); }
    std::string as_string() const { return std::get<std::string>(value_); }

private:
    std::string name_;
    std::variant<double, std::string> value_;
};
struct SensorDataQoS {};
namespace node_interfaces {
struct OnSetParametersCallbackHandle {
    using SharedPtr = std::shared_ptr<OnSetParametersCallbackHandle>;
};
}  // namespace node_interfaces
template <class T>
struct Publisher {
    using SharedPtr = std::shared_ptr<Publisher>;
    std::vector<T> sent;
    void publish(const T &message) { sent.push_back(message); }
};
template <class T>
struct Subscription {
    using SharedPtr = std::shared_ptr<Subscription>;
};
template <class T>
struct Service {
    using SharedPtr = std::shared_ptr<Service>;
};

/* What the node made, by name. */
inline std::map<std::string, std::any> made;

class Node {
public:
    explicit Node(std::string) {}
    template <class T>
    T declare_parameter(const std::string &, T value) {
        return value;
    }
    template <class F>
    node_interfaces::OnSetParametersCallbackHandle::SharedPtr add_on_set_parameters_callback(F call) {
        made["set"] = std::function<rcl_interfaces::msg::SetParametersResult(const std::vector<Parameter> &)>(call);
        return nullptr;
    }
    template <class T>
    typename Publisher<T>::SharedPtr create_publisher(const std::string &name, SensorDataQoS) {
        auto publisher = std::make_shared<Publisher<T>>();
        made[name] = publisher;
        return publisher;
    }
    template <class T, class F>
    typename Subscription<T>::SharedPtr create_subscription(const std::string &name, SensorDataQoS, F call) {
        made[name] = std::function<void(const typename T::SharedPtr)>(call);
        return nullptr;
    }
    template <class T, class F>
    typename Service<T>::SharedPtr create_service(const std::string &name, F call) {
        made[name] = std::function<void(typename T::Request::SharedPtr, typename T::Response::SharedPtr)>(call);
        return nullptr;
    }
};
inline void init(int, char **) {}
template <class T>
void spin(std::shared_ptr<T>) {}
inline void shutdown() {}
}  // namespace rclcpp
