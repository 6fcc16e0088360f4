"""The words of signals in many languages speak for them; those of viscosity, temperature and frequency for none."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.logs.columns.names import spoken_name
from tests.support.plans_of_columns import planned

WORDS = {
    "slip": "Velocidad angular;Vitesse de rotation;"
    "Drehgeschwindigkeit;Winkelgeschw.;velocità angolare;"
    "活塞速度;角速度;回転数;ピストン速度;각속도;prędkość kątowa;devir;nopeus;hoeksnelheid",
    "effort": "Fuerza de amortiguamiento;Force d'amortissement;"
    "Dämpfungskraft;força de amortecimento;binário;momento torcente;"
    "阻尼力;制动力矩;減衰力;ブレーキトルク;감쇠력;제동토크;moment hamujący;"
    "siła tłumienia;sönümleme kuvveti;fren torku;remkoppel;voima;par de frenado;torque de frenagem;тормозной момент",
    "field": "Corriente de bobina;intensidad;Voltaje;courant de bobine;intensité;champ magnétique;Spulenstrom;"
    "Magnetfeld;corrente da bobina;Tensão;Tensione;励磁电流;磁场;コイル電流;코일 전류;prąd cewki;bobin akımı;"
    "spoelstroom;jännite;ток катушки;campo magnético",
    "position": "Desplazamiento;Posición;Course;Kolbenweg;curso;corsa;angolo;位移;変位;변위;przemieszczenie;kąt;"
    "yer değiştirme;posun;siirtymä;förskjutning;läge;перемещение",
}
PAIRS = [(signal, word) for signal, words in WORDS.items() for word in words.split(";")]


@pytest.mark.parametrize(("signal", "word"), PAIRS)
def test_a_word_speaks_for_its_signal(signal: str, word: str) -> None:
    assert signal in spoken_name(word).may_be


@pytest.mark.parametrize(
    "word", ["Zeit", "Temps", "Tiempo", "时间", "時間", "czas", "zaman", "aika"]
)
def test_a_word_is_a_time(word: str) -> None:
    assert spoken_name(word).is_time


@pytest.mark.parametrize(
    "word",
    "Viscosidad;viscosité;Viskosität;viscosità;粘度;점도;Temperatur;temperatuur;sıcaklık;teplota;温度;온도;"
    "frecuencia;fréquence;Frequenz;frekans;频率;частота".split(";"),
)
def test_a_viscosity_a_temperature_and_a_frequency_are_no_signal(word: str) -> None:
    said = spoken_name(word)
    assert not said.may_be
    assert said.is_accounted


@pytest.mark.parametrize(
    "header",
    [
        "czas [s];prędkość [rad/s];prąd cewki [A];moment hamujący [N*m]",
        "zaman [s];hız [rad/s];bobin akımı [A];fren torku [N*m]",
        "tiempo [s];velocidad [rad/s];corriente [A];par de frenado [N*m]",
        "時間 [s];角速度 [rad/s];コイル電流 [A];ブレーキトルク [N*m]",
        "시간 [s];각속도 [rad/s];코일 전류 [A];제동토크 [N*m]",
    ],
)
def test_a_log_in_a_language_is_understood_at_once(header: str) -> None:
    rows = np.arange(200.0)
    turn = np.sin(rows / 9)
    columns = [rows / 100, turn, 0.5 * (rows // 20 % 3), turn**3]
    plan = planned(dict(zip(header.split(";"), columns, strict=True)))
    assert not plan.questions
    assert {each.signal for each in plan.signals} == {"slip", "field", "effort"}
