"""A node that offers the interfaces of the package type_matrix: a topic, a service, an action.

`python -m tests.support.type_server` prints `ready` and runs until SIGINT.
"""

from __future__ import annotations

import rclpy
from matrix_parts.msg import Part
from rclpy.action import ActionServer
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from type_matrix.action import Fold
from type_matrix.msg import Nested, Strings
from type_matrix.srv import Swap

PERIOD_S = 0.1
WORD = "grüße \U0001f916"


class TypeServer(Node):
    def __init__(self) -> None:
        super().__init__("type_server")
        self._nested = self.create_publisher(Nested, "nested", 10)
        self.create_service(Swap, "swap", self._swap)
        self._server = ActionServer(self, Fold, "fold", self._fold)
        self._timer = self.create_timer(PERIOD_S, self._talk)

    def _talk(self) -> None:
        message = Nested(strings=[Strings(wide_brief="äöü"), Strings(few_briefs=["a", "b"])])
        message.part = Part(name=WORD, values=[-(2**31), 2**31 - 1])
        message.own.state = 255
        message.header.frame_id = "map"
        self._nested.publish(message)

    def _swap(self, request: Swap.Request, response: Swap.Response) -> Swap.Response:
        response.other = request.one
        response.parts = [Part(name=request.word)]
        return response

    def _fold(self, goal: object) -> Fold.Result:
        order = goal.request.order
        for number in range(order):
            goal.publish_feedback(Fold.Feedback(progress=WORD, share=number / order))
        goal.succeed()
        return Fold.Result(sequence=list(range(order)), last=Part(name=WORD))


def main() -> None:
    try:
        rclpy.init()
        node = TypeServer()
        print("ready", flush=True)
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
