# SPDX-License-Identifier: Apache-2.0
"""Makes measurements from start to end: the action server around `flatplank_control.runner`."""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any

from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn
from std_msgs.msg import String
from std_srvs.srv import Trigger

from flatplank_control.nodes.bench_samples import BenchSamples
from flatplank_control.nodes.campaign_runner import WISHES, CampaignRunner
from flatplank_control.nodes.charge import DEPTH, LOOK, TOPIC, Watched
from flatplank_control.nodes.ros_bench import RosBench, Seen
from flatplank_control.runner.campaign import is_campaign
from flatplank_control.runner.dry_run import Progress, dry_run_progress
from flatplank_control.runner.plans import axes_of, mapping_of, measurement_of, plan_of
from flatplank_control.runner.steps import BUSY, PlanFailed
from flatplank_data.params import Params, param
from flatplank_hw.nodes.late_clients import until_heard
from flatplank_hw.nodes.responses import fill_response
from flatplank_hw.nodes.running import run_node
from flatplank_hw.nodes.support import BenchNode
from flatplank_msgs.action import RunMeasurement

OFTEN = 1.0
"""interval of the feedback during a wait [s of wall clock]"""
SHARE = 0.05
"""progress after which feedback is sent at once, since a simulated bench may be fast [-]"""


CLIENT_GONE = "the client that asked for it has gone: ask again, the run is made anew"


class Feedback:
    """Feedback of one goal."""

    def __init__(self, goal: Any) -> None:
        self.message = RunMeasurement.Feedback(measurements=1, measurement=1)
        self._goal = goal
        self._progress: Progress | None = None
        self._step, self._published_at, self._share = 0, 0.0, 0.0

    def send_text(self, text: str, prompt: str = "") -> None:
        """Send what is going on, and what the operator must do."""
        self.message.step, self.message.prompt = text, prompt
        self._goal.publish_feedback(self.message)

    def follow_plan(self, progress: Progress) -> None:
        """Start to follow the steps of a single measurement."""
        self._progress, self._step, self._share = progress, 0, 0.0
        self.send_progress(0.0)

    def next_step(self) -> None:
        """Count one more completed step."""
        self._step += 1
        self.send_progress(0.0)

    def send_progress(self, seconds: float) -> None:
        """Send the progress after `seconds` of the present step [s of bench time]."""
        progress, now = self._progress, time.monotonic()
        if progress is None:
            return
        self.message.progress = progress.done(self._step, seconds)
        self.message.time_left = progress.left(self._step, seconds)
        due = now - self._published_at >= OFTEN or self.message.progress - self._share >= SHARE
        if due and not self.message.prompt:
            self._published_at, self._share = now, self.message.progress
            self._goal.publish_feedback(self.message)


@dataclass(frozen=True)
class RunnerParameters(Params):
    """Options of the runner."""

    held: bool = param(
        False, "simulated bus in pace hold: cycles are asked for, runs repeat exactly"
    )
    driven_plank: bool = param(False, "the plank has a drive instead of the switch")


class MeasurementRunnerNode(BenchNode):
    """Serves action /run_measurement; the operator answers prompts with ~/confirm."""

    PARAMETERS = RunnerParameters

    def connect(self) -> None:
        self.busy = False
        self.asking = False
        """true while a prompt waits for the operator"""
        self.server_name = self.resolve_service_name("run_measurement")
        self.server = ActionServer(
            self,
            RunMeasurement,
            "run_measurement",
            self.execute,
            goal_callback=self.on_goal,
            cancel_callback=lambda _goal: CancelResponse.ACCEPT,
        )
        self.campaign: CampaignRunner | None = None
        self.bench: RosBench | None = None
        self.client = Watched()
        self.add_subscription(String, TOPIC, self.client.hear, DEPTH, needed=False)
        self.add_timer(LOOK, self.client.look)
        self.add_service(Trigger, "~/confirm", self.on_confirm)
        self.add_service(Trigger, "~/enough", self.on_enough)
        for wish in WISHES:
            self.add_service(Trigger, f"~/{wish}", partial(self.on_wish, wish))

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.server.destroy()
        return super().on_deactivate(state)

    async def on_goal(self, _request: RunMeasurement.Goal) -> GoalResponse:
        """Accept a goal when no other is under way, once its client can hear the answers."""
        await until_heard(self, self.server_name)
        if not self.busy:
            return GoalResponse.ACCEPT
        self.troubles.report_occurrence(
            "refused", f"{self.server_name}: a measurement is under way"
        )
        return GoalResponse.REJECT

    def on_confirm(
        self, _request: Trigger.Request, response: Trigger.Response
    ) -> Trigger.Response:
        asking, self.asking = self.asking, False
        return fill_response(response, asking, "confirmed" if asking else "nothing is being asked")

    def on_enough(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        """End the present run here and keep it."""
        if self.bench is None:
            return fill_response(response, False, "no measurement is under way")
        self.bench.enough = True
        return fill_response(response, True, "the run ends here and is kept")

    def on_wish(
        self, wish: str, _request: Trigger.Request, response: Trigger.Response
    ) -> Trigger.Response:
        if self.campaign is None:
            return fill_response(response, False, "no campaign is under way")
        self.campaign.wish = wish
        return fill_response(response, True, f"{wish} of the present run")

    async def execute(self, goal: ServerGoalHandle) -> RunMeasurement.Result:
        if self.busy:  # two goals were accepted at the same moment
            goal.abort()
            return RunMeasurement.Result(message=BUSY)
        self.busy = True
        self.client.begin(goal.request.heartbeat)
        feedback = Feedback(goal)

        async def ask(text: str, seen: Seen) -> None:
            feedback.send_text(text, prompt=text)
            self.asking = True
            try:
                await bench.wait_until(lambda: not self.asking or seen())
            finally:
                self.asking = False
            feedback.send_text(text)

        request = goal.request
        bench = RosBench(
            self.outside,
            BenchSamples(partial(self.add_serialised_subscription, needed=False)),
            held=self.parameters.held,
            simulated=request.simulated,
            driven_plank=self.parameters.driven_plank,
            folder=request.folder,
            prompt=ask,
            say=feedback.send_text,
        )
        result = RunMeasurement.Result()
        try:
            self.bench = bench
            data = mapping_of(request.plan)
            if is_campaign(data):
                result.message = await self.make_campaign(goal, bench, feedback)
            else:
                result.message = await self.make_measurement(goal, bench, data, feedback)
            result.success = True
        except Exception as error:  # after any error the bench is left safe
            result.message = await self.end_safely(bench, error, request.simulated)
        finally:
            with suppress(PlanFailed):  # a drive that has ended holds nothing
                await bench.release_charge()
            bench.close()
            self.busy, self.bench, self.campaign = False, None, None
        result.bags = bench.bags
        self.set_goal_state(goal, result.success)
        return result

    async def end_safely(self, bench: RosBench, error: Exception, simulated: bool) -> str:
        """Leave the bench safe if a step has begun; returns the reason for the client."""
        reason = " ".join(str(error).split()) or type(error).__name__
        if not bench.begun:
            self.troubles.report_occurrence("refused", f"{self.server_name}: {reason}")
            return reason
        self.troubles.report_occurrence("measurement_stopped", reason)
        for refusal in await bench.end_safely("stopped", reason):
            self.get_logger().warning(refusal)
        if not simulated and bench.samples.plank_moves():
            reason += "; turn the plank switch to stop"
        return reason

    async def make_measurement(
        self, goal: ServerGoalHandle, bench: RosBench, data: Any, feedback: Feedback
    ) -> str:
        """Make a single measurement."""

        bench.interrupt = look = partial(self.look_at_client, goal)
        wanted = measurement_of(data)
        bench.axes = axes_of(wanted)
        bench.on_step_time = feedback.send_progress
        feedback.follow_plan(dry_run_progress(plan_of(wanted)))
        for step in plan_of(wanted):
            look()
            await bench.perform(step)
            feedback.next_step()
        return "complete"

    async def make_campaign(
        self, goal: ServerGoalHandle, bench: RosBench, feedback: Feedback
    ) -> str:
        """Make a campaign; its journal lies beside its bags."""
        request = goal.request
        self.campaign = campaign = CampaignRunner(
            bench, request.plan, request.folder, request.resume
        )

        def send_campaign_progress(text: str) -> None:
            conductor = campaign.conductor
            message = feedback.message
            message.measurements = conductor.total
            message.measurement = min(conductor.done + 1, conductor.total)
            message.progress = conductor.done / conductor.total
            message.time_left = campaign.time_left()
            feedback.send_text(text)

        before = campaign.conductor.done
        await campaign.run(partial(self.look_at_client, goal), send_campaign_progress)
        if before == campaign.conductor.total:
            return f"all {before} runs were there; another folder begins anew"
        return "complete"

    def look_at_client(self, goal: ServerGoalHandle) -> None:
        """Raise PlanFailed when the client has cancelled, or died."""
        if goal.is_cancel_requested:
            raise PlanFailed("cancelled")
        if self.client.gone:
            raise PlanFailed(CLIENT_GONE)

    @staticmethod
    def set_goal_state(goal: ServerGoalHandle, success: bool) -> None:
        if success:
            goal.succeed()
        elif goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()


NODE = MeasurementRunnerNode


def main(args: list[str] | None = None) -> int:
    return run_node(lambda: NODE("measurement_runner"), args)


if __name__ == "__main__":
    raise SystemExit(main())
