"""FNN-16: erclutch and peers, on the same normalised rows."""

from __future__ import annotations

from functools import partial
from math import cos, pi
from time import perf_counter, process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rows import HIDDEN, NETWORK, Split
from task import Fit, Task
from watch import Predict

from erclutch.fit.networks.first_weights import first_weights
from erclutch.fit.networks.fit_network import fit_network
from erclutch.models.networks import network_from_name

Array = NDArray[np.float64]


def erclutch(task: Task, polish: bool = False) -> Predict:
    """Erclutch's own fit: 4 starts, coarse to fine."""
    structure = network_from_name(NETWORK)
    found = fit_network(
        task.train.data, structure, seed=task.seed, polish=polish, workers=task.threads
    )
    task.notes.append(f"{found.stop}, {found.iterations} steps")
    return lambda split: found.model.predict(split.data)


# --- a network in NumPy, for the solvers that want a residual and a Jacobian ------------------------------------------


def start(task: Task) -> Array:
    """Weights after Nguyen and Widrow, as MATLAB starts and as erclutch does: W (16, 3), b (16,), w (16,), c."""
    return first_weights(np.random.default_rng([task.seed, 0]), (3, HIDDEN, 1))


def output(theta: Array, x: Array) -> Array:
    """Output for rows x (n, 3), shape (n,)."""
    return np.tanh(x @ theta[:48].reshape(HIDDEN, 3).T + theta[48:64]) @ theta[64:80] + theta[80]


def jacobian(theta: Array, x: Array) -> Array:
    """Derivatives of the output by all weights, shape (n, 81)."""
    h = np.tanh(x @ theta[:48].reshape(HIDDEN, 3).T + theta[48:64])
    s = (1.0 - h * h) * theta[64:80]
    j = np.empty((x.shape[0], theta.size))
    np.multiply(s[:, :, None], x[:, None, :], out=j[:, :48].reshape(-1, HIDDEN, 3))
    j[:, 48:64], j[:, 64:80], j[:, 80] = s, h, 1.0
    return j


def of_theta(task: Task, theta: Array) -> Predict:
    """Prediction with a copy of these weights."""
    return task.effort(partial(output, theta.copy()))


def numpy_trainlm(task: Task) -> Predict:
    """Levenberg-Marquardt as MATLAB's trainlm: J'J over all rows, mu / 10 on success, mu * 10 else, 1000 epochs."""
    x, y = task.train.x, task.train.y
    theta, mu = start(task), 1e-3
    residual = y - output(theta, x)
    for epoch in range(1000):
        j = jacobian(theta, x)
        square, slope, cost = j.T @ j, j.T @ residual, float(residual @ residual)
        del j
        while mu <= 1e10:
            trial = theta + np.linalg.solve(square + mu * np.eye(theta.size), slope)
            after = y - output(trial, x)
            if float(after @ after) < cost:
                break
            mu *= 10.0
        else:
            task.notes.append(f"mu at its largest after {epoch} epochs")
            break
        theta, residual, mu = trial, after, mu / 10.0
        task.watch.look(of_theta(task, theta))
    return of_theta(task, theta)


def scipy_least_squares(task: Task, method: Any) -> Predict:
    """scipy.optimize.least_squares with the analytic Jacobian and its default tolerances."""
    from scipy.optimize import least_squares

    task.watch.start()
    x, y = task.train.x, task.train.y

    def slopes(theta: Array) -> Array:
        task.watch.look(of_theta(task, theta))
        return jacobian(theta, x)

    found = least_squares(
        lambda theta: output(theta, x) - y, start(task), jac=slopes, method=method
    )
    task.notes.append(f"status {found.status}, {found.nfev} evaluations")
    return of_theta(task, found.x)


# --- scikit-learn -----------------------------------------------------------------------------------------------------


def sklearn_lbfgs(task: Task) -> Predict:
    """MLPRegressor with L-BFGS, looked at whenever its loss falls."""
    from sklearn.neural_network import MLPRegressor

    class Seen(MLPRegressor):
        def _loss_grad_lbfgs(self, *args: Any) -> Any:
            loss, gradient = super()._loss_grad_lbfgs(*args)
            if task.watch.better(float(loss)):
                tables = [table.copy() for table in (*self.coefs_, *self.intercepts_)]
                task.watch.look(task.effort(partial(_forward, tables)))
            return loss, gradient

    net = Seen(
        hidden_layer_sizes=(HIDDEN,),
        activation="tanh",
        solver="lbfgs",
        alpha=0.0,
        max_iter=100_000,
        max_fun=10**9,
        tol=1e-9,
        random_state=task.seed,
    )
    task.watch.start()
    net.fit(task.train.x, task.train.y)
    task.notes.append(f"{net.n_iter_} iterations")
    return task.effort(net.predict)


def _forward(tables: list[Array], x: Array) -> Array:
    first, last, b, c = tables
    return (np.tanh(x @ first + b) @ last)[:, 0] + c[0]


def sklearn_adam(task: Task) -> Predict:
    """MLPRegressor with Adam at its default rate and batch, an epoch at a time until the limit."""
    from sklearn.neural_network import MLPRegressor

    net = MLPRegressor(
        hidden_layer_sizes=(HIDDEN,),
        activation="tanh",
        solver="adam",
        alpha=0.0,
        random_state=task.seed,
    )
    task.watch.start()
    while True:
        net.partial_fit(task.train.x, task.train.y)
        task.watch.look(task.effort(net.predict))


# --- PyTorch ----------------------------------------------------------------------------------------------------------


def _torch_net(task: Task, kind: str) -> tuple[Any, Any, Any, Any]:
    """Module torch, network, inputs and targets."""
    import torch

    torch.set_num_threads(task.threads)
    torch.manual_seed(task.seed)
    dtype = getattr(torch, kind)
    net = torch.nn.Sequential(
        torch.nn.Linear(3, HIDDEN), torch.nn.Tanh(), torch.nn.Linear(HIDDEN, 1)
    ).to(dtype)
    spare = torch.nn.Linear(1, 1)
    spare(torch.ones(1, 1)).sum().backward()
    torch.optim.Adam(spare.parameters()).step()  # the first step loads more of torch
    task.watch.start()
    return (
        torch,
        net,
        torch.tensor(task.train.x, dtype=dtype),
        torch.tensor(task.train.y[:, None], dtype=dtype),
    )


def _torch_predict(task: Task, torch: Any, net: Any) -> Predict:
    def of_unit(x: Array) -> Array:
        with torch.no_grad():
            return net(torch.tensor(x, dtype=next(net.parameters()).dtype))[:, 0].double().numpy()

    return task.effort(of_unit)


def torch_adam(task: Task, share: float = 1.0) -> Predict:
    """Adam, batches of 1024, float32; the rate falls from 0.01 to 0 by a cosine over a share of the CPU limit."""
    torch, net, x, y = _torch_net(task, "float32")
    optimiser = torch.optim.Adam(net.parameters(), lr=1e-2)
    budget, predict = share * task.watch.limit, _torch_predict(task, torch, net)
    while (spent := task.watch.seconds()) < budget:
        for group in optimiser.param_groups:
            group["lr"] = 0.5e-2 * (1.0 + cos(pi * spent / budget))
        for rows in torch.randperm(y.shape[0]).split(1024):
            optimiser.zero_grad()
            torch.nn.functional.mse_loss(net(x[rows]), y[rows]).backward()
            optimiser.step()
        task.watch.look(predict)
    return predict


def torch_lbfgs(task: Task) -> Predict:
    """L-BFGS on all rows with a strong Wolfe search, float64."""
    torch, net, x, y = _torch_net(task, "float64")
    how = {"max_iter": 5, "history_size": 50, "line_search_fn": "strong_wolfe"}
    optimiser = torch.optim.LBFGS(net.parameters(), tolerance_grad=0, tolerance_change=0, **how)

    def closure() -> Any:
        optimiser.zero_grad()
        loss = torch.nn.functional.mse_loss(net(x), y)
        loss.backward()
        return loss

    while True:
        optimiser.step(closure)
        task.watch.look(_torch_predict(task, torch, net))


def torch_lm(task: Task) -> Predict:
    """torch-levenberg-marquardt on all rows in float32, solving J'J by its "solve"; a step at a time."""
    import torch_levenberg_marquardt as tlm

    torch, net, x, y = _torch_net(task, "float32")
    module = tlm.training.LevenbergMarquardtModule(
        net, loss_fn=tlm.loss.MSELoss(), solve_method="solve"
    )
    predict = _torch_predict(task, torch, net)
    for step in range(1000):
        _, _, stop, _ = module.training_step(x, y)
        task.watch.look(predict)
        if stop:
            task.notes.append(f"stopped itself after {step + 1} steps")
            break
    return predict


# --- JAX --------------------------------------------------------------------------------------------------------------


def jax_sysid(task: Task) -> Predict:
    """jax-sysid's StaticModel: as many Adam epochs as L-BFGS ones, doubled in fresh fits while the limit allows."""
    from jax_sysid import models  # noqa: F401  # not on the clock

    task.watch.stop()
    epochs, cpu, growth = 50, 0.0, 0.0
    predict: Predict | None = None
    while predict is None or cpu + growth <= task.watch.limit:
        before, began, wall = cpu, process_time(), perf_counter()
        predict = _jax_fit(task, epochs)
        cpu = process_time() - began
        task.watch.record(cpu, perf_counter() - wall, predict)
        task.notes[:] = [f"last fit {epochs} + {epochs} epochs"]
        growth, epochs = 2.0 * (cpu - before), 2 * epochs
    return predict


def _jax_fit(task: Task, epochs: int) -> Predict:
    import jax.numpy as jnp
    from jax_sysid.models import StaticModel

    def network(u: Any, params: Any) -> Any:
        w, b, v, c = params
        return jnp.tanh(u @ w.T + b) @ v + c

    theta = start(task)
    model = StaticModel(1, 3, network)
    model.init(params=[theta[:48].reshape(HIDDEN, 3), theta[48:64], theta[64:80, None], theta[80:]])
    model.loss(rho_th=1e-8)
    model.optimization(adam_epochs=epochs, lbfgs_epochs=epochs, iprint=-1, memory=20)
    model.fit(task.train.y[:, None], task.train.x)

    def predict(split: Split) -> Array:
        return task.effort(lambda x: np.asarray(model.predict(x))[:, 0])(split)

    return predict


FITS: dict[str, Fit] = {
    "erclutch": erclutch,
    "erclutch polish": partial(erclutch, polish=True),
    "NumPy LM as trainlm": numpy_trainlm,
    "scipy least_squares lm": partial(scipy_least_squares, method="lm"),
    "scipy least_squares trf": partial(scipy_least_squares, method="trf"),
    "scikit-learn lbfgs": sklearn_lbfgs,
    "scikit-learn adam": sklearn_adam,
    "torch Adam cosine": torch_adam,
    "torch Adam cosine, limit/4": partial(torch_adam, share=0.25),
    "torch LBFGS": torch_lbfgs,
    "torch-levenberg-marquardt": torch_lm,
    "jax-sysid": jax_sysid,
}
