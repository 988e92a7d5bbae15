"""Settings → law."""

from controllers.laws.barrier_qp import BarrierQP
from controllers.laws.continuous_inverse import ContinuousInverse
from controllers.laws.intermediate_value import IntermediateValue
from controllers.laws.null_space_avoidance import NullSpaceAvoidance
from controllers.laws.potential_field import PotentialField
from controllers.laws.set_based_task import SetBasedTask
from controllers.laws.situation import Law
from controllers.laws.smooth_priority import SmoothPriority
from controllers.laws.strict_priority import StrictPriority
from controllers.laws.task_activation import TaskActivation
from controllers.laws.unprotected import Unprotected
from scenes.settings import LawSettings


def make_law(settings: LawSettings) -> Law:
    """Return the law that the settings describe."""
    d_m, n, v = settings.critical_distance, settings.order, settings.nominal_velocity
    match settings.law:
        case "smooth_priority":
            return SmoothPriority(d_m, n, v, settings.feed_forward, settings.one_sided)
        case "strict_priority":
            return StrictPriority(d_m, v, switched=False)
        case "strict_switched":
            return StrictPriority(d_m, v, switched=True)
        case "null_space_avoidance":
            return NullSpaceAvoidance(d_m, settings.influence_distance, v)
        case "potential_field":
            return PotentialField(settings.influence_distance, settings.field_strength)
        case "barrier_qp":
            return BarrierQP(d_m, settings.barrier_gain, settings.feed_forward)
        case "intermediate_value":
            return IntermediateValue(d_m, n, v)
        case "task_activation":
            return TaskActivation(d_m, settings.influence_distance, v)
        case "continuous_inverse":
            return ContinuousInverse(d_m, n, v)
        case "set_based_task":
            return SetBasedTask(d_m, settings.restoring_gain, settings.feed_forward)
        case "unprotected":
            return Unprotected()
