/* ${title}
   A node of ROS 2 around the C of ${name}.c. A message of the joint is a sample; a template to begin from: copy it
   before you change it.

   ${generated} */
#include <cmath>
#include <memory>
#include <string>

#include "${name}.hpp"
#include "rcl_interfaces/msg/set_parameters_result.hpp"
#include "rclcpp/rclcpp.hpp"
#include "sensor_msgs/msg/joint_state.hpp"
#include "std_msgs/msg/float64.hpp"
#include "std_msgs/msg/float64_multi_array.hpp"
#include "std_srvs/srv/trigger.hpp"

class ${name}Node : public rclcpp::Node {
public:
    ${name}Node() : rclcpp::Node("${name}") {
        joint_ = declare_parameter<std::string>("joint", "steering");
        load_ = declare_parameter<double>("load", std::nan(""));
        ratio_ = declare_parameter<double>("ratio", 1.0);
        torque_sign_ = declare_parameter<double>("torque_sign", 1.0);
        checked_ = add_on_set_parameters_callback(
            [this](const std::vector<rclcpp::Parameter> &changes) { return set(changes); });
        estimate_ = create_publisher<std_msgs::msg::Float64MultiArray>("~/estimate", rclcpp::SensorDataQoS());
        joints_ = create_subscription<sensor_msgs::msg::JointState>(
            "joint_states", rclcpp::SensorDataQoS(),
            [this](const sensor_msgs::msg::JointState::SharedPtr message) { take(*message); });
        loads_ = create_subscription<std_msgs::msg::Float64>(
            "load", rclcpp::SensorDataQoS(),
            [this](const std_msgs::msg::Float64::SharedPtr message) { load_ = message->data; });
        reset_ = create_service<std_srvs::srv::Trigger>(
            "~/reset", [this](const std_srvs::srv::Trigger::Request::SharedPtr,
                              std_srvs::srv::Trigger::Response::SharedPtr response) {
                observer_.reset();
                response->success = true;
            });
    }

private:
    /* Parameters that may change while the node runs. joint, load: where a sample comes from; ratio: of the joint's
       angle to that of the wheel; torque_sign: -1 where the joint's effort is the other torque. */
    rcl_interfaces::msg::SetParametersResult set(const std::vector<rclcpp::Parameter> &changes) {
        rcl_interfaces::msg::SetParametersResult result;
        result.successful = false;
        for (const auto &change : changes) {
            const std::string &name = change.get_name();
            if (name == "ratio" && !(std::abs(change.as_double()) > 0.0)) result.reason = "ratio must not be 0";
            if (name == "load" && change.as_double() <= 0.0) result.reason = "load must be greater than 0 N";
            if (name == "torque_sign" && std::abs(change.as_double()) != 1.0) result.reason = "torque_sign must be 1 or -1";
        }
        if (!result.reason.empty()) return result;
        for (const auto &change : changes) {
            const std::string &name = change.get_name();
            if (name == "joint") joint_ = change.as_string();
            if (name == "load") load_ = change.as_double();
            if (name == "ratio") ratio_ = change.as_double();
            if (name == "torque_sign") torque_sign_ = change.as_double();
        }
        result.successful = true;
        return result;
    }

    /* position [rad], velocity [rad/s], effort [N m] of the joint; what the message lacks is missing. */
    void take(const sensor_msgs::msg::JointState &message) {
        for (std::size_t i = 0; i < message.name.size(); ++i) {
            if (message.name[i] != joint_) continue;
            const double now = rclcpp::Time(message.header.stamp).seconds();
            ${name}::Sample sample;
            if (i < message.position.size()) sample.psi = static_cast<${real}>(message.position[i] / ratio_);
            if (i < message.velocity.size()) sample.psi_dot = static_cast<${real}>(message.velocity[i] / ratio_);
            if (i < message.effort.size()) sample.${torque} = static_cast<${real}>(torque_sign_ * message.effort[i]);
            sample.F_N = static_cast<${real}>(load_);
            sample.dt = static_cast<${real}>(now - last_);
            const bool first = !(last_ < now);
            last_ = now;
            if (first) return;
            observer_.step(sample);
            publish();
            return;
        }
    }

    /* ${estimate|join(", ")}, and weaker: the share of mu_eff and M_slide that the weaker direction holds less. */
    void publish() {
        const auto now = observer_.estimate();
        std_msgs::msg::Float64MultiArray message;
        message.layout.dim.resize(1);
        message.layout.dim[0].label = "${estimate|join(",")},weaker";
        message.layout.dim[0].size = ${estimate|length + 1};
        message.layout.dim[0].stride = ${estimate|length + 1};
        message.data.push_back(static_cast<double>(now.${name})); %% for name in estimate
        message.data.push_back(static_cast<double>(${NAME ~ "_WEAKER" if weaker else "std::nan(\"\")"}));
        estimate_->publish(message);
    }

    ${name}::Observer observer_;
    std::string joint_;
    double load_, ratio_, torque_sign_, last_ = std::nan("");
    rclcpp::node_interfaces::OnSetParametersCallbackHandle::SharedPtr checked_;
    rclcpp::Publisher<std_msgs::msg::Float64MultiArray>::SharedPtr estimate_;
    rclcpp::Subscription<sensor_msgs::msg::JointState>::SharedPtr joints_;
    rclcpp::Subscription<std_msgs::msg::Float64>::SharedPtr loads_;
    rclcpp::Service<std_srvs::srv::Trigger>::SharedPtr reset_;
};

int main(int argc, char **argv) {
    rclcpp::init(argc, argv);
    rclcpp::spin(std::make_shared<${name}Node>());
    rclcpp::shutdown();
    return 0;
}
