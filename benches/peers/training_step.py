"""One training step of the population network in PyTorch, eager mode on the processor.

Sixty Euler steps of ten networks of the paper's widths over a batch, the paper's loss, its gradient
and Adam: what `cargo xtask bench --what training-step` times for our own code. Prints one line of
JSON. Needs PyTorch; data and weights are random, which changes no operation.
"""

import argparse
import json
import statistics
import time

import torch

# Inputs of each network by column: Q1, Q2, S1, S2, I, X1, X2, X3, C2, C1, insulin, carbohydrate.
Q1, Q2, S1, S2, I, X1, X2, X3, C2, C1, INSULIN, CARBS = range(12)
INPUTS = [
    [X1, X3, Q1, Q2, C2],
    [X1, X2, Q1, Q2],
    [S1, INSULIN],
    [S1, S2],
    [S2, I],
    [I, X1],
    [I, X2],
    [I, X3],
    [C1, C2],
    [C1, CARBS],
]
WIDTHS = [248, 80, 174, 60, 197, 191, 101, 127, 140, 149]
WEIGHTS = [5 / 24, 1 / 6] + [1 / 12] * 7 + [1 / 24]
MINUTES = 5.0
ALPHA, BETA = 0.7, 0.08


class Population(torch.nn.Module):
    def __init__(self):
        super().__init__()
        self.networks = torch.nn.ModuleList(
            torch.nn.Sequential(
                torch.nn.Linear(len(inputs), width),
                torch.nn.ReLU(),
                torch.nn.Linear(width, 1),
            )
            for inputs, width in zip(INPUTS, WIDTHS)
        )
        for network in self.networks:
            # Small rates, so that the random roll-outs stay small.
            network[2].weight.data *= 0.1
            network[2].bias.data *= 0.1

    def forward(self, state, inputs):
        states = []
        for step_inputs in inputs:
            signals = torch.cat([state, step_inputs], 1)
            rates = [net(signals[:, columns]) for net, columns in zip(self.networks, INPUTS)]
            state = state + MINUTES * torch.cat(rates, 1)
            states.append(state)
        return torch.stack(states)


def loss_of(simulated, truth, low, high, least, weights, error_weights):
    glucose, true_glucose = simulated[:, :, Q1], truth[:, :, Q1]
    penalty = torch.ones_like(glucose)
    penalty[(true_glucose <= low) & (glucose > true_glucose)] = 2.0
    penalty[(true_glucose >= high) & (glucose < true_glucose)] = 6.0
    fit = ((glucose - true_glucose) ** 2 * penalty).mean()
    squares = (((simulated - truth) ** 2).mean((0, 1)) * error_weights).sum()
    below = (torch.relu(least - simulated).mean((0, 1)) * weights).sum()
    return fit + ALPHA * (squares + BETA * below)


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--threads", type=int, required=True)
    arguments.add_argument("--batch", type=int, default=128)
    arguments.add_argument("--steps", type=int, default=60)
    arguments.add_argument("--rounds", type=int, default=30)
    options = arguments.parse_args()
    torch.set_num_threads(options.threads)
    torch.manual_seed(1)
    model = Population()
    optimiser = torch.optim.Adam(model.parameters(), lr=1e-3)
    initial = torch.randn(options.batch, 10)
    inputs = torch.randn(options.steps, options.batch, 2)
    truth = torch.randn(options.steps, options.batch, 10)
    weights = torch.tensor(WEIGHTS)
    error_weights = weights.clone()
    error_weights[C1] = 0.0
    least = torch.full((10,), -1.0)

    def step():
        optimiser.zero_grad()
        simulated = model(initial, inputs)
        loss_of(simulated, truth, -0.6, 1.6, least, weights, error_weights).backward()
        optimiser.step()

    for _ in range(5):
        step()
    times = []
    for _ in range(options.rounds):
        begun = time.perf_counter()
        step()
        times.append(1e3 * (time.perf_counter() - begun))
    parameters = sum(p.numel() for p in model.parameters())
    result = {
        "engine": f"PyTorch {torch.__version__} eager",
        "parameters": parameters,
        "median_ms": statistics.median(times),
        "least_ms": min(times),
    }
    print(json.dumps(result))


if __name__ == "__main__":
    main()
