# SPDX-License-Identifier: Apache-2.0
"""Makes a measurement from beginning to end: the action server over `flatplank_control.runner`."""

from __future__ import annotations

from dataclasses import dataclass

import yaml
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.task import Future
from std_srvs.srv import Trigger

from flatplank_control.nodes.ros_bench import RosBench
from flatplank_control.runner import measurement, plans
from flatplank_control.runner.steps import PlanFailed, StopRecord
from flatplank_hw.nodes.support import BenchNode, run
from flatplank_hw.params import Params, param
from flatplank_msgs.action import RunMeasurement


@dataclass(frozen=True)
class RunnerParameters(Params):
    """How measurements are made."""

    held: bool = param(False, "simulated bus in pace hold: cycles are asked for, runs repeat exactly")


class MeasurementRunnerNode(BenchNode):
    """Action /run_measurement; the operator answers prompts with ~/confirm."""

    PARAMETERS = RunnerParameters

    def connect(self) -> None:
        self.busy = False
        self.confirmation: Future | None = None
        self.server = ActionServer(
            self,
            RunMeasurement,
            "/run_measurement",
            self.execute,
            goal_callback=self.on_goal,
            cancel_callback=lambda _goal: CancelResponse.ACCEPT,
        )
        self.serve(Trigger, "~/confirm", self.on_confirm)

    def on_deactivate(self, state):
        self.server.destroy()
        return super().on_deactivate(state)

    def on_goal(self, _request) -> GoalResponse:
        return GoalResponse.REJECT if self.busy else GoalResponse.ACCEPT

    def on_confirm(self, _request, response):
        waiting = self.confirmation is not None and not self.confirmation.done()
        if waiting:
            self.confirmation.set_result(None)
        response.success = waiting
        response.message = "" if waiting else "nothing is being asked"
        return response

    async def execute(self, goal):
        self.busy = True
        feedback = RunMeasurement.Feedback(measurements=1, measurement=1)

        def say(text: str, prompt: str = "") -> None:
            feedback.step, feedback.prompt = text, prompt
            goal.publish_feedback(feedback)

        async def ask(text: str) -> None:
            say(text, prompt=text)
            self.confirmation = Future()
            await self.confirmation

        request = goal.request
        bench = RosBench(
            self,
            held=self.parameters.held,
            simulated=request.simulated,
            folder=request.folder,
            prompt=ask,
            say=say,
        )
        result = RunMeasurement.Result()
        try:
            m = measurement.from_mapping(yaml.safe_load(request.plan) or {}, "plan")
            for step in plans.plan_of(m):
                if goal.is_cancel_requested:
                    raise PlanFailed("cancelled")
                await bench.do(step)
            result.success, result.message = True, "complete"
        except (PlanFailed, ValueError, yaml.YAMLError) as error:
            result.message = " ".join(str(error).split())
            self.get_logger().error(result.message)
            await self.end_safely(bench, result.message)
        finally:
            bench.close()
            self.busy = False
        result.bags = bench.bags
        self.conclude(goal, result.success)
        return result

    async def end_safely(self, bench: RosBench, reason: str) -> None:
        for step in (*plans.safe_end(), StopRecord("stopped", reason)):
            try:
                await bench.do(step)
            except PlanFailed as error:
                self.get_logger().warning(str(error))

    @staticmethod
    def conclude(goal, success: bool) -> None:
        if success:
            goal.succeed()
        elif goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()


def main(args: list[str] | None = None) -> int:
    return run(lambda: MeasurementRunnerNode("measurement_runner"), args)


if __name__ == "__main__":
    raise SystemExit(main())
