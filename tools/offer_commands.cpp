// The commands `service` and `action`.

#include <memory>

#include "prehend/graph/introspection.h"
#include "prehend/text/command_line.h"
#include "tools/action_send.h"
#include "tools/commands.h"
#include "tools/json.h"
#include "tools/service_call.h"
#include "tools/table.h"

namespace prehend::tools {
namespace {

struct OfferChoices {
  std::string registry, name;
  bool json = false;
};

void list_offers(const OfferChoices& choices, bool actions) {
  Json list = Json::array();
  std::vector<std::vector<std::string>> rows{
      {actions ? "ACTION" : "SERVICE", actions ? "GOAL, FEEDBACK, RESULT" : "REQUEST, RESPONSE",
       "NODE"}};
  for (const auto& node : graph::Introspection(choices.registry).nodes()) {
    for (const auto& offer : actions ? node.actions() : node.services()) {
      const std::vector<std::string> types(offer.type_names().begin(), offer.type_names().end());
      list.add(
          Json::object().set("name", offer.name()).set("types", types).set("node", node.name()));
      rows.push_back({offer.name(), joined(types), node.name()});
    }
  }
  if (choices.json) return print(list);
  print_table(rows);
}

void add_list(CLI::App& group, const std::string& kind, bool actions) {
  auto choices = std::make_shared<OfferChoices>();
  CLI::App* list = group.add_subcommand("list", "List them with their types and nodes");
  add_registry_option(*list, choices->registry);
  add_json_option(*list, choices->json);
  list->footer("Example:\n  prehend " + kind + " list");
  list->callback([choices, actions] { list_offers(*choices, actions); });
}

void add_service_commands_to(CLI::App& group, Outcome& outcome) {
  add_list(group, "service", false);
  auto options = std::make_shared<CallOptions>();
  CLI::App* call = group.add_subcommand("call", "Call a service and print its response");
  call->add_option("service", options->service, "The service")->required();
  call->add_option("request", options->text, "Protobuf text or JSON; default: an empty request");
  call->add_option("-t,--timeout", options->timeout, "Longest wait for the response [s]")
      ->check(text::above_zero())
      ->capture_default_str();
  add_registry_option(*call, options->registry);
  add_json_option(*call, options->json);
  call->footer(
      "Examples:\n"
      "  prehend service call /gripper/stop\n"
      "  prehend service call /clock/control '{\"command\": \"PAUSE\"}'");
  call->callback([options, &outcome] { outcome.exit_code = call_service(*options); });
}

void add_action_commands_to(CLI::App& group, Outcome& outcome) {
  add_list(group, "action", true);
  auto options = std::make_shared<SendOptions>();
  CLI::App* send = group.add_subcommand(
      "send", "Send a goal, print feedback and result; Ctrl-C cancels the goal");
  send->add_option("action", options->action, "The action")->required();
  send->add_option("goal", options->text, "Protobuf text or JSON; default: an empty goal");
  send->add_option("-t,--timeout", options->timeout, "Cancel the goal after so long [s]; 0: never")
      ->check(text::above_zero(true));
  send->add_flag("-q,--quiet", options->quiet, "Print no feedback");
  add_registry_option(*send, options->registry);
  add_json_option(*send, options->json);
  send->footer("Example:\n  prehend action send /gripper/move 'opening: 0.03 speed: 0.05'");
  send->callback([options, &outcome] { outcome.exit_code = send_goal(*options); });

  auto choices = std::make_shared<OfferChoices>();
  CLI::App* cancel =
      group.add_subcommand("cancel", "Cancel the goal of an action, whoever sent it");
  cancel->add_option("action", choices->name, "The action")->required();
  add_registry_option(*cancel, choices->registry);
  cancel->footer("Example:\n  prehend action cancel /gripper/move");
  cancel->callback(
      [choices] { graph::Introspection(choices->registry).cancel_action(choices->name); });
}

}  // namespace

void add_offer_commands(CLI::App& app, Outcome& outcome) {
  CLI::App* services = app.add_subcommand("service", "Look at and call the services nodes offer");
  services->require_subcommand(1);
  add_service_commands_to(*services, outcome);
  CLI::App* actions =
      app.add_subcommand("action", "Look at the actions nodes offer, send and cancel goals");
  actions->require_subcommand(1);
  add_action_commands_to(*actions, outcome);
}

}  // namespace prehend::tools
