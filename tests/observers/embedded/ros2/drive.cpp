/* Sends the node a table of samples t,psi,torque and prints what it publishes; a reset after the last. */
#include <cstdio>

#define main node_main
#include "brushgrip_node.cpp"
#undef main

using Values = std::vector<rclcpp::Parameter>;

int main() {
    brushgripNode node;
    auto &made = rclcpp::made;
    const auto set = std::any_cast<std::function<rcl_interfaces::msg::SetParametersResult(const Values &)>>(made["set"]);
    const auto joint = std::any_cast<std::function<void(const sensor_msgs::msg::JointState::SharedPtr)>>(made["joint_states"]);
    const auto load = std::any_cast<std::function<void(const std_msgs::msg::Float64::SharedPtr)>>(made["load"]);
    const auto sent = std::any_cast<rclcpp::Publisher<std_msgs::msg::Float64MultiArray>::SharedPtr>(made["~/estimate"]);
    const auto reset = std::any_cast<std::function<void(std_srvs::srv::Trigger::Request::SharedPtr, std_srvs::srv::Trigger::Response::SharedPtr)>>(made["~/reset"]);
    const bool refused = !set(Values{{"ratio", 0.0}}).successful && !set(Values{{"load", -1.0}}).successful && !set(Values{{"torque_sign", 2.0}}).successful;
    const bool taken = set(Values{{"ratio", 2.0}, {"torque_sign", -1.0}, {"joint", std::string("wheel")}}).successful;
    load(std::make_shared<std_msgs::msg::Float64>(std_msgs::msg::Float64{400.0}));
    double t, psi, torque;
    while (std::scanf("%lf,%lf,%lf", &t, &psi, &torque) == 3) {
        auto message = std::make_shared<sensor_msgs::msg::JointState>();
        message->header.stamp = t;
        message->name = {"other", "wheel"};
        message->position = {9.0, 2.0 * psi};
        message->effort = {9.0, -torque};
        joint(message);
    }
    for (const auto &message : sent->sent) {
        for (const double value : message.data) std::printf("%.17g ", value);
        std::printf("\n");
    }
    auto response = std::make_shared<std_srvs::srv::Trigger::Response>();
    reset(nullptr, response);
    return refused && taken && response->success && sent->sent[0].layout.dim[0].size == sent->sent[0].data.size() ? 0 : 1;
}
