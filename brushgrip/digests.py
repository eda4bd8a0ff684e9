"""The published measurements and simulations: where they are, and the SHA-256 of every file."""

from dataclasses import dataclass

_RAW = "https://raw.githubusercontent.com/gyorokbendeguz"
_RIG = f"{_RAW}/GyB_TDK_2023/dd82a2b79db81138d017f91cbf45e8afcfbc5335"
_THESIS = f"{_RAW}/BSc-Thesis/02fc92afd2953d63f70f9ecc485552959e782eec"


@dataclass(frozen=True, kw_only=True)
class Publication:
    """Files of one published folder.

    Attributes:
        url: the folder at the pinned commit.
        prefix: put before the published name, where two folders use the same names.
        digests: SHA-256 by published name.
    """

    url: str
    prefix: str = ""
    digests: dict[str, str]


MEASUREMENTS = Publication(
    url=f"{_RIG}/SimulationEnv/Old_meas",
    digests={
        "fem1.mat": "592b7c6660047c4e75945b5f037985344d9944f8df213caf98365cefc379950b",
        "fem2.mat": "a3508c98fb2cdeadc7393486cbe9ab0b090cdd850022794bf6f340ba86e2b6c2",
        "fem3.mat": "8dc25d63397b291b636b56e7a3a18213b1ea2daaedeae4e718c977dd9440e819",
        "fem4_ident.mat": "4cd34bdcde7b46e961957aa1810f6147d831aa98cb3bd92401f72b31f03847cc",
        "fem5.mat": "1ec2ae5aabaee51415c920ebc7dec94d5a1d15c396080b4d01b45067b3f465fa",
        "fem6.mat": "6c1c688b9b87bc0552e0ae3c1ecad88d9b9ab300c377cc9c7c39cb11e1b61af8",
        "piros1.mat": "81547a8681577b91ae496717c0afa70f65cbb7785f7f0386684c356a1100b220",
        "piros2_ident.mat": "f121f253768d5edea0f2a5b566f1389d4dbc6886629b75057ca956ca91ca765b",
        "piros3.mat": "a30022f267bcf796746df5508f44608408a16856dee4329059b9e8b450c6eeb1",
        "piros4.mat": "6b22c9459de35da3bb06eb3662cd2971595deefa7f26482986c68a9151cfc064",
        "piros5.mat": "10614c82896f7fe40539476e9eb7b1826017699c86bc4a3e2e140aa5893c8c42",
        "piros6.mat": "131f9c82c744e27d26ed99aa2462358ad870b6663d3715aac44d1cf718e99d51",
        "piros7.mat": "98910c99e9c47cb5b5b8eac4cde9fe6163e5b7cc4c2160799450f9fcd135b4aa",
    },
)
"""Recordings on the rig: fem*, steel plate; piros*, red emery."""

AUTHOR_ESTIMATES = Publication(
    url=f"{_RIG}/ANN_ErrorPrediction/Data",
    prefix="author_estimate_",
    digests={
        "fem1.csv": "42598bb4003b64131cfec62ca51d4c2ebca3e2ccfcbced4f8a0b00ce7a0b5685",
        "fem2.csv": "1caf02bf2c3e8fb55c9441bbf2296e7a7d1cade29aa35d92982851ae02cd2e27",
        "fem3.csv": "57d31f210d8b863f7a516d2896d64f17b0b4ad653841db924a821a3d0882cf8b",
        "fem4.csv": "f259e3f96e17a699098a0e50db984880526fb02f43c66bf0c6775373fd2b5553",
        "fem5.csv": "563eb5b4856d7a293007844c4124ef0f5932dac84f736b4b38458d9d0abad1b0",
        "fem6.csv": "d599e3773a668ad61408fc53eb17925665cd36de3c1896f2e02db07557cb15bc",
        "piros1.csv": "49566490edb4d3602f4b0dc729d6a38e06fcd8fcc96d1f618fffa75a34aa8d14",
        "piros2.csv": "f39ab386ce01c0e41c16193ef6bbc998bd339a9abbef2b23d61fc967a99e4fe8",
        "piros3.csv": "02f7c73581be5de9e354d12e92543b391e54b43117642ef39872616bc84efd2d",
        "piros4.csv": "bd892d14d2eb4a6d0c15e19abc2cfce79598f785d8467f1828b4c49db20fbaa5",
        "piros5.csv": "369eb98bcdf67e47371f50b7619d3fcf8dfea3224c5d3350fd563280cb265f0d",
        "piros6.csv": "b37aebcfdf03e537d077c85eba4b713c83ba468c5b0def6b533aef27e696aeb2",
        "piros7.csv": "66b4b890eb56c1c138c7ee249d27cadb2ac44df0906120452f1c5aa9be7fdcf3",
    },
)
"""The author's own estimates of friction along those recordings."""

SIMULATIONS = Publication(
    url=f"{_THESIS}/MachineLearning/SimulationResults",
    digests={
        "sim_mu_05.csv": "5840aaa08733a61e985ca585d6e47eeaf64fa88dddbab1c33734cb36615bf6fa",
        "sim_mu_1.csv": "ccefbbcdc04c6c7e3fdede25884967cc93998f356e73c2e74ad1fe95b40ffe81",
        "sim_mu_18.csv": "3805c49a77176a09f4b28be79725334410227051b40311f0595eb0f13197d29a",
    },
)
"""Simulations of the thesis, friction 0.5, 1 and 1.8."""

PUBLICATIONS = (MEASUREMENTS, AUTHOR_ESTIMATES, SIMULATIONS)
