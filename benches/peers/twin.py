"""A digital twin in PyTorch, eager mode on the processor.

`--what days`: a twin runs freely through many days at once, in the operations of the published
package: one step after the other, all runs in a batch, each signal picked by its own index and
joined again for each network, glucose confined by masks, no gradients. `--what training`: one update on a
batch of five-hour windows, gradient through all steps, AdamW. What `cargo xtask bench --what twins`
times for our own code. Prints one line of JSON. Needs PyTorch; weights and data are random, which
changes no operation.
"""

import argparse
import json
import resource
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
SEEN = [Q1, Q2, X1, X3, C2]
MINUTES = 5.0
ALPHA = 10.0


class Twin(torch.nn.Module):
    def __init__(self):
        super().__init__()
        self.population = torch.nn.ModuleList(
            torch.nn.Sequential(
                torch.nn.Linear(len(inputs), width),
                torch.nn.ReLU(),
                torch.nn.Linear(width, 1),
            )
            for inputs, width in zip(INPUTS, WIDTHS)
        )
        for network in self.population:
            # Small rates, so that the random runs stay small; the population is frozen.
            network[2].weight.data *= 0.1
            network[2].bias.data *= 0.1
        self.population.requires_grad_(False)
        self.residual = torch.nn.Sequential(
            torch.nn.Linear(10, 128),
            torch.nn.ReLU(),
            torch.nn.Linear(128, 64),
            torch.nn.ReLU(),
            torch.nn.Linear(64, 32),
            torch.nn.ReLU(),
            torch.nn.Linear(32, 1),
        )
        self.residual[6].weight.data *= 0.01

    def forward(self, state, inputs, personal):
        glucose = [state[:, Q1]]
        for step_inputs, step_personal in zip(inputs, personal):
            x = [state[..., [k]] for k in range(10)]
            signals = x + [step_inputs[..., [0]], step_inputs[..., [1]]]
            rates = [
                net(torch.cat([signals[k] for k in columns], -1))
                for net, columns in zip(self.population, INPUTS)
            ]
            seen = [state[..., [k]] for k in range(10)]
            residual = self.residual(torch.cat([seen[k] for k in SEEN] + [step_personal], -1))
            change = torch.cat(rates, -1)
            change = torch.cat([change[..., :1] + residual, change[..., 1:]], -1)
            state = state + MINUTES * change
            confined = state[:, 0].clone()
            confined[confined > 3.4] = 3.4
            confined[confined < -1.1] = -1.1
            state = torch.cat([confined[:, None], state[:, 1:]], -1)
            glucose.append(state[:, Q1])
        return torch.stack(glucose, 1)


def loss_of(simulated, measured):
    error = simulated - measured
    penalty = torch.ones_like(error)
    penalty[(measured <= -0.7) & (error > 0)] = 8.5
    penalty[(measured >= 1.5) & (error < 0)] = 6.0
    differences = error[:, 1:] - error[:, :-1]
    return (penalty * error**2)[:, 1:].mean() + ALPHA * (differences**2).mean()


def processor_seconds():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--what", choices=["days", "training"], required=True)
    arguments.add_argument("--threads", type=int, required=True)
    arguments.add_argument("--runs", type=int, required=True)
    arguments.add_argument("--steps", type=int, required=True)
    arguments.add_argument("--rounds", type=int, default=5)
    options = arguments.parse_args()
    torch.set_num_threads(options.threads)
    torch.manual_seed(1)
    twin = Twin()
    state = torch.randn(options.runs, 10)
    inputs = torch.randn(options.steps, options.runs, 2)
    personal = torch.randn(options.steps, options.runs, 5)
    measured = torch.randn(options.runs, options.steps + 1)
    optimiser = torch.optim.AdamW(twin.residual.parameters(), lr=1e-4, weight_decay=1e-5)

    def days():
        with torch.no_grad():
            twin(state, inputs, personal)

    def training():
        optimiser.zero_grad()
        loss_of(twin(state, inputs, personal), measured).backward()
        optimiser.step()

    turn = days if options.what == "days" else training
    turn()
    times, processor = [], []
    for _ in range(options.rounds):
        begun, used = time.perf_counter(), processor_seconds()
        turn()
        times.append(1e3 * (time.perf_counter() - begun))
        processor.append(1e3 * (processor_seconds() - used))
    result = {
        "engine": f"PyTorch {torch.__version__} eager",
        "parameters": sum(p.numel() for p in twin.parameters()),
        "median_ms": statistics.median(times),
        "least_ms": min(times),
        "median_processor_ms": statistics.median(processor),
    }
    print(json.dumps(result))


if __name__ == "__main__":
    main()
